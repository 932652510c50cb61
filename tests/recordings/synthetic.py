"""Telemetry rows as a running rig sends them, without a rig: a tip on a circle, with noise, modes and lost slots."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from controller.arrays import Rows, Values
from controller.schema.layout import layout_hash, record_dtype
from controller.schema.messages import Command, RigInfo, Telemetry
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import BACKBONE_POINTS, SENSORS, RigParameters, Settings
from recordings.format.messages import Recording
from recordings.write.writer import Recorder

LENGTH = 0.253
START_NS = 7_654_321_000_000_000
LOST_AT = 1500
"""One slot in this many is skipped, as a stall of the machine would."""


def rig_info() -> RigInfo:
    return RigInfo(
        rig="bench",
        boot=1763664000123456789,
        version="0.1.0",
        layout=layout_hash(Command, Telemetry),
        wall_offset_ns=1_760_000_000_000_000_000,
        policy="SCHED_FIFO 50",
        twin=True,
        parameters=RigParameters(),
    )


def telemetry_rows(count: int, first: int = 0) -> Rows:
    """`count` ticks from `first` on: the same numbers however they are cut into batches."""
    ticks = np.arange(first, first + count)
    rows = np.zeros(count, record_dtype(Telemetry))
    _fill_clock(rows, ticks)
    _fill_state(rows, ticks)
    _fill_motion(rows, ticks * 1e-3)
    _fill_power(rows, ticks * 1e-3)
    return rows


def batches(rows: Rows, size: int = 10) -> Iterator[Rows]:
    """The rows as the link hands them over."""
    for start in range(0, len(rows), size):
        yield rows[start : start + size]


def recorded(folder: Path, name: str, rows: Rows) -> Recording:
    """`rows` recorded under `name` by the real recorder, whole and closed."""
    recorder = Recorder(folder)
    recorder.start(name, rig_info(), Settings())
    for batch in batches(rows, 250):
        recorder.rows(batch)
    found = recorder.stop()
    recorder.close()
    return found


def _noise(ticks: Values, salt: int) -> Values:
    """Reproducible values in [-1, 1] with full mantissas, a function of the tick alone."""
    return np.sin(ticks * 12.9898 + salt * 78.233) * np.cos(ticks * 4.1414 + salt)


def _fill_clock(rows: Rows, ticks: Values) -> None:
    rows["tick"] = ticks
    rows["lost"] = ticks // LOST_AT
    rows["slot"] = ticks + rows["lost"]
    rows["lateness_ns"] = 18_000 + 9_000 * np.abs(_noise(ticks, 1)) + 400_000 * (ticks % 997 == 0)
    rows["t_ns"] = START_NS + rows["slot"] * 1_000_000 + rows["lateness_ns"]
    rows["step_ns"] = 9_000 + 900 * np.abs(_noise(ticks, 2))


def _fill_state(rows: Rows, ticks: Values) -> None:
    rows["mode"] = np.select([ticks < 300, ticks < 800], [Mode.VENTED, Mode.HOLD], Mode.FOLLOW)
    rows["cause"] = np.where(ticks < 300, Cause.START, Cause.OPERATOR)
    rows["request_cause"] = Cause.NONE
    rows["command_n"] = rows["request_n"] = ticks // 8
    rows["presence"] = ticks // 50
    rows["law"] = 4
    rows["sensed"] = 512
    rows["reachable"] = 1
    rows["saturated"] = ticks % 1000 < 5
    rows["measurement_age"] = 0.004 + 1e-3 * (ticks % 10) + 1e-6 * _noise(ticks, 3)
    rows["operator_age"] = 1e-3 * (ticks % 50) + 1e-6 * np.abs(_noise(ticks, 4))
    rows["server_age"] = 1e-3 * (ticks % 8) + 1e-6 * np.abs(_noise(ticks, 5))


def _circle(t: Values) -> Values:
    turn = np.pi * t
    return np.stack([0.03 + 0.04 * np.cos(turn), 0.14 + 0.04 * np.sin(turn)], 1)


def _fill_motion(rows: Rows, t: Values) -> None:
    ticks, lag = rows["tick"], 0.03
    rows["target"] = _circle(ticks // 8 * 8e-3)
    rows["p_ref"] = _circle(t)
    rows["p_ref_dot"] = (_circle(t + 1e-6) - _circle(t - 1e-6)) / 2e-6
    rows["p_hat"] = _circle(t - lag) + 1e-5 * _noise(ticks, 6)[:, None]
    rows["backbone"] = arc(rows["p_hat"], BACKBONE_POINTS)
    rows["twin_backbone"] = arc(_circle(t - lag) + 0.001, BACKBONE_POINTS)
    seen = ticks // 10
    noise = np.stack([_noise(seen, 7 + i) for i in range(2 * SENSORS)], 1).reshape(-1, SENSORS, 2)
    rows["markers"] = arc(_circle(seen * 1e-2 - lag) + 0.001, SENSORS + 1)[:, 1:] + 1e-4 * noise
    rows["markers"][:, 3] = np.nan
    rows["p_meas"] = rows["markers"][:, -1]
    rows["error"] = rows["p_ref"] - rows["p_meas"]
    rows["integral"] = 0.05 * (_circle(t) - 0.08)
    rows["residual"] = np.linalg.norm(rows["p_meas"] - rows["p_hat"], axis=1)


def _fill_power(rows: Rows, t: Values) -> None:
    ticks = rows["tick"]
    turn = 2 * np.pi * 0.5 * t
    rows["u_ff"] = 0.025 + 0.01 * np.stack([np.cos(turn), np.sin(turn)], 1)
    rows["u_fb"] = 1e-3 * np.stack([_noise(ticks, 30), _noise(ticks, 31)], 1)
    rows["u"] = rows["u_ff"] + rows["u_fb"]
    rows["u_hat"] = 0.9 * rows["u_ff"]
    rows["pressure_cmd"][:, ::2] = rows["u"] * 241.3e3 / 0.060
    rows["pressure_meas"] = rows["pressure_cmd"] * 0.97 + 200 * np.stack([_noise(ticks, 40 + i) for i in range(4)], 1)
    rows["energy"] = 0.05 + 0.01 * np.sin(turn)
    rows["power"] = 0.01 * np.stack([_noise(ticks, 50 + i) for i in range(4)], 1)
    rows["ledger"] = 1e-9 * t


def arc(tip: Values, points: int) -> Values:
    """Circular arcs of the backbone's chord from the origin, tangent to +x, to each tip (n,2): (n,points,2) [m]."""
    chord = np.linalg.norm(tip, axis=1)[:, None]
    bend = np.arctan2(tip[:, 1], tip[:, 0])[:, None]
    s = np.linspace(0.0, 1.0, points)[None, :]
    radius = chord / (2 * np.sin(bend))
    return np.stack([radius * np.sin(2 * bend * s), radius * (1 - np.cos(2 * bend * s))], 2)
