"""The units of the two services, as they lie beside this file, with the path of this installation."""

import sys
from pathlib import Path

PLACE = "/opt/tendril/bin"
"""Where the units say that tendril is."""


def unit_text(name: str) -> str:
    """Unit "rig" or "server" for the tendril that runs now."""
    text = (Path(__file__).parent / f"tendril-{name}.service").read_text()
    return text.replace(PLACE, str(Path(sys.executable).parent))
