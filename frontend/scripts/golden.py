"""Write the golden bytes of the page's decoder test: a telemetry frame and plot bins, encoded by the server's code.

Run from the repository root: `.venv/bin/python frontend/scripts/golden.py`.
"""

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from controller.schema.layout import fields, record_dtype
from controller.schema.messages import Telemetry
from server.plots.feed import encode_frame, encode_plot
from server.rig.history import Bins

TARGET = Path(__file__).parents[1] / "src" / "live" / "__fixtures__" / "golden.json"


def numbered_row() -> np.ndarray[Any, Any]:
    """A telemetry row in which every element is another number; one nan, one negative, one beyond 32 bits."""
    row = np.zeros(1, record_dtype(Telemetry))
    value = 1
    for name in row.dtype.names or ():
        flat = row[name].reshape(-1)
        flat[:] = np.arange(value, value + flat.size) * (0.5 if flat.dtype.kind == "f" else 1)
        value += flat.size
    row["t_ns"] = 123_456_789_012_345
    row["cause"] = -2
    row["p_meas"] = np.nan, 0.25
    return row


def main() -> None:
    """Write the file."""
    row = numbered_row()
    low = np.array([[1, 2, np.nan], [4, 5, 6]], np.float32)
    bins = Bins(7, [0, 3, 5], np.array([1.0, 1.016]), low, low + 6)
    values = {name: [None if x != x else x for x in row[name].reshape(-1).tolist()] for name in row.dtype.names or ()}
    golden = {
        "layout": [field.model_dump() for field in fields(Telemetry)],
        "values": values,
        "frame": base64.b64encode(encode_frame(row)).decode(),
        "plot": base64.b64encode(encode_plot(bins)).decode(),
    }
    TARGET.write_text(json.dumps(golden, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
