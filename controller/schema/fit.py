"""The fitted numbers, as data: what the twin and the gains are by default (`tendril calibrate` writes the file)."""

import tomllib
from pathlib import Path
from typing import Any

FIT_FILE = Path(__file__).with_name("fit.toml")
FIT: dict[str, Any] = tomllib.loads(FIT_FILE.read_text("utf-8"))
"""Tables "fit" (date, cost, command), "twin" (fields of TwinParameters) and "gains" (GAIN_NAMES)."""

TWIN: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in FIT["twin"].items()}
GAIN_NAMES = ("K_P", "K_I", "K_FF")
"""What of the controller is fitted, here and wherever gains are listed."""
GAINS: dict[str, float] = FIT["gains"]
