"""The plotted signals: which telemetry elements the page can plot, and how rows become one float32 matrix."""

from typing import Any

import numpy as np
import numpy.typing as npt

from server.messages import PlotChannel

Rows = np.ndarray[Any, Any]


def _channel(key: str, label: str, unit: str, field: str, index: int | None = 0) -> PlotChannel:
    return PlotChannel(key=key, label=label, unit=unit, field=field, index=index)


def _pair(key: str, label: str, unit: str, field: str, names: str = "12") -> list[PlotChannel]:
    return [_channel(f"{key}{name}", f"{label} {name}", unit, field, i) for i, name in enumerate(names)]


CHANNELS: list[PlotChannel] = [
    *(_channel(f"{axis}_ref", f"{axis} reference", "m", "p_ref", i) for i, axis in enumerate("xy")),
    *(_channel(f"{axis}_meas", f"{axis} measured", "m", "p_meas", i) for i, axis in enumerate("xy")),
    *(_channel(f"{axis}_hat", f"{axis} observer", "m", "p_hat", i) for i, axis in enumerate("xy")),
    _channel("error", "error", "m", "error", None),
    _channel("residual", "observer residual", "m", "residual"),
    *_pair("pressure_meas_", "pressure", "Pa", "pressure_meas", "1234"),
    *_pair("pressure_cmd_", "pressure command", "Pa", "pressure_cmd", "1234"),
    *_pair("u_", "u", "N m", "u"),
    *_pair("u_ff_", "feedforward", "N m", "u_ff"),
    *_pair("u_fb_", "feedback", "N m", "u_fb"),
    *(_channel(f"v{axis}_ref", f"{axis} reference speed", "m/s", "p_ref_dot", i) for i, axis in enumerate("xy")),
    _channel("energy", "energy", "J", "energy"),
    _channel("ledger", "energy ledger", "J", "ledger"),
    _channel("measurement_age", "measurement age", "s", "measurement_age"),
    _channel("step", "step time", "ns", "step_ns"),
    _channel("lateness", "wake-up lateness", "ns", "lateness_ns"),
]


def extract(rows: Rows) -> npt.NDArray[np.float32]:
    """Values of all channels, (n, channels), of n telemetry rows."""
    out = np.empty((len(rows), len(CHANNELS)), np.float32)
    for j, channel in enumerate(CHANNELS):
        values = rows[channel.field]
        if channel.index is None:
            out[:, j] = np.hypot(values[:, 0], values[:, 1])
        else:
            out[:, j] = values if values.ndim == 1 else values[:, channel.index]
    return out
