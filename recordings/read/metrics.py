"""How well the tip followed, from a recording's rows. The tip is the measured one, as in a run's result card.

Rows are what `recordings.read.reader.read_rows` gives. What a profile or an import does not hold gives null.
"""

import math
from dataclasses import replace

import numpy as np

from controller.arrays import Columns, Values
from controller.schema.layout import Model
from controller.schema.modes import Mode
from controller.schema.parameters import DT, SENSORS
from controller.simulation.metrics import feedback_share, ise, phase_lags, sse
from recordings.format.messages import Metrics
from recordings.read.course import followed_rows
from recordings.read.period import Period, find_period

FIELDS = (
    *("slot", "mode", "sensed", "p_ref", "p_meas", "u_ff", "u_fb", "saturated", "residual"),
    *("backbone", "twin_backbone"),
)
"""All that is needed of a recording."""


class Measured(Model):
    """A recording's metrics, and those of each cycle of a periodic reference."""

    whole: Metrics
    cycles: tuple[Metrics, ...]


def metrics_of(rows: Columns) -> Metrics:
    """Of the whole recording: the rows in which a run was followed; of all where there was none."""
    part = followed(rows)
    return _metrics(part, _period(part)).model_copy(update={"approach": approach(rows)})


def cycles_of(rows: Columns) -> list[Metrics]:
    """One for each whole period of a reference that was periodic to the end; none for any other."""
    part = followed(rows)
    found = _period(part)
    if found is None:
        return []
    alone = replace(found, start=0)
    return [_metrics(_only(part, slice(*cycle)), alone) for cycle in found.cycles(_count(part))]


def followed(rows: Columns) -> Columns:
    """The rows of runs that began in the recording, without those that are known to lead into them or to travel.

    Without any such note the rows in mode TRACK; all where no row is in that mode.
    """
    if not _tracked(rows).any():
        return rows
    return _only(rows, followed_rows(rows["mode"], rows.get("approach")))


def approach(rows: Columns) -> float | None:
    """How long runs were led into [s], which `followed` leaves out; None where the recording does not say."""
    return float(np.count_nonzero(rows["approach"] & _tracked(rows))) * _dt(rows) if "approach" in rows else None


class ErrorSums:
    """What errors come to, however many there are: the figures of a run's card and of its recording.

    e = p_ref - p_meas at every tick that saw the tip. p_ref is the rig's own, which is in the recording: where the rig
    did follow its plan late or elsewhere, its plan is not what the tip was led along.
    """

    def __init__(self) -> None:
        self._count, self._ise, self._most = 0, 0.0, 0.0

    def add(self, p_ref: Values, p_meas: Values) -> None:
        """Count the ticks (n, 2) [m]."""
        e = p_ref - p_meas
        e = e[np.isfinite(e).all(axis=1)]
        self._count += len(e)
        self._ise += ise(e, 1.0)
        self._most = max(self._most, float(np.linalg.norm(e, axis=1).max(initial=0.0)))

    @property
    def rmse(self) -> float | None:
        """sqrt(mean |e|^2) [m]; None where the tip never was seen."""
        return math.sqrt(self._ise / self._count) if self._count else None

    @property
    def largest(self) -> float | None:
        """Max |e| [m]."""
        return self._most if self._count else None


def errors(p_ref: Values, p_meas: Values, dt: float) -> dict[str, float]:
    """Of e = p_ref - p_meas (n, 2) [m] where the tip was seen; rows are dt [s] apart. Empty where it never was.

    rmse = sqrt(mean |e|^2), max_error = max |e|, sse = mean |e| over the last tenth, ise = dt sum |e|^2.
    """
    e = p_ref - p_meas
    e = e[np.isfinite(e).all(axis=1)]
    if not len(e):
        return {}
    sums = ErrorSums()
    sums.add(p_ref, p_meas)
    return {"rmse": sums.rmse or 0.0, "max_error": sums.largest or 0.0, "sse": sse(e), "ise": ise(e, dt)}


def saturated_share(saturated: Values) -> float | None:
    """Mean of the flags (n,): share of the ticks whose command was clamped."""
    return float(np.mean(saturated != 0)) if len(saturated) else None


def rms(values: Values) -> float | None:
    """sqrt(mean |v|^2) over the rows (n,) or (n, k) of `values` that are finite; None without any."""
    rows = values.reshape(len(values), math.prod(values.shape[1:]))
    seen = rows[np.isfinite(rows).all(axis=1)]
    return math.sqrt(float(np.mean(np.sum(seen**2, axis=1)))) if len(seen) else None


def lost_ticks(slot: Values, tick: Values) -> tuple[int, float | None]:
    """Slots without their tick, sum (d slot - d tick), and the share that had theirs, sum d tick / sum d slot.

    Counted between neighbouring rows, so ticks missing in the file are not lost; a restart of the rig is passed over.
    """
    slots, ticks = np.diff(slot), np.diff(tick)
    on = (ticks > 0) & (slots >= ticks)
    all_slots, all_ticks = int(slots[on].sum()), int(ticks[on].sum())
    return all_slots - all_ticks, all_ticks / all_slots if all_slots else None


def share_of_feedback(u_ff: Values, u_fb: Values) -> float | None:
    """Mean |u_fb| / mean (|u_ff| + |u_fb|) over the rows (n, 2) [N m] that are known; None without any torque."""
    known = np.isfinite(u_ff).all(axis=1) & np.isfinite(u_fb).all(axis=1)
    u_ff, u_fb = u_ff[known], u_fb[known]
    return feedback_share(u_ff, u_fb) if u_ff.any() or u_fb.any() else None


def unsensed_rms(rows: Columns) -> float | None:
    """sqrt(mean |r_i - r_i twin|^2) over the rods i that were not sensed, wherever both backbones are known [m]."""
    if "sensed" not in rows or not _count(rows, "backbone") or not _count(rows, "twin_backbone"):
        return None
    at_rows, ours_at = _clocks(rows, "backbone")
    both, a, b = np.intersect1d(ours_at, _clocks(rows, "twin_backbone")[1], return_indices=True)
    _, c, d = np.intersect1d(both, at_rows, return_indices=True)
    ours, twins = rows["backbone"][a[c]], rows["twin_backbone"][b[c]]
    at = np.arange(1, SENSORS + 1) * (ours.shape[1] - 1) // SENSORS
    unsensed = (rows["sensed"][d].astype(np.int64)[:, None] >> np.arange(SENSORS)) & 1 == 0
    return rms((ours[:, at].astype(np.float64) - twins[:, at])[unsensed])


def _metrics(rows: Columns, period: Period | None) -> Metrics:
    found: dict[str, float | None] = {}
    if "p_ref" in rows and "p_meas" in rows:
        found |= errors(rows["p_ref"], rows["p_meas"], _dt(rows)) | _lags(rows, period)
    if "saturated" in rows:
        found["saturated_share"] = saturated_share(rows["saturated"])
    if "residual" in rows:
        found["residual_rms"] = rms(rows["residual"])
    if "u_ff" in rows:
        found["feedback_share"] = share_of_feedback(rows["u_ff"], rows["u_fb"])
    if _count(rows) and "slot" in rows:
        found["lost"], found["on_time_share"] = lost_ticks(rows["slot"], rows["tick"])
    return Metrics(**found, unsensed_rms=unsensed_rms(rows))


def _lags(rows: Columns, period: Period | None) -> dict[str, float]:
    """Phase lags over the rows that are periodic; a phase is the same whatever the time between two rows."""
    if period is None:
        return {}
    return phase_lags(rows["p_ref"][period.start :], rows["p_meas"][period.start :], period.swings, 1.0)


def _tracked(rows: Columns) -> Values:
    return np.asarray(rows["mode"] == Mode.TRACK) if "mode" in rows else np.zeros(_count(rows), bool)


def _period(rows: Columns) -> Period | None:
    return find_period(rows["p_ref"], _dt(rows)) if "p_ref" in rows else None


def _dt(rows: Columns) -> float:
    """Usual time between two rows [s]."""
    return float(np.median(np.diff(rows["t_ns"]))) * 1e-9 if _count(rows, "t_ns") > 1 else DT


def _count(rows: Columns, name: str = "tick") -> int:
    return len(rows[name]) if name in rows else 0


def _clocks(rows: Columns, name: str) -> tuple[Values, Values]:
    """What tells the rows and the slower values of `name` apart: times where they are known, as the ticks of a rig that
    restarted begin again.
    """
    kind = "t_ns" if f"{name}_t_ns" in rows else "tick"
    return rows[kind], rows[f"{name}_{kind}"]


def _only(rows: Columns, which: Values | slice) -> Columns:
    """The rows picked by `which`, and of the slower values, which have clocks of their own, those at these rows."""
    slow = [name for name in rows if f"{name}_tick" in rows]
    clocks = {name: [clock for clock in (f"{name}_tick", f"{name}_t_ns") if clock in rows] for name in slow}
    slower = {*slow, *(clock for found in clocks.values() for clock in found)}
    out = {name: values[which] for name, values in rows.items() if name not in slower}
    for name in slow:
        at_rows, at = _clocks(rows, name)
        keep = np.isin(at, at_rows[which])
        out |= {column: rows[column][keep] for column in (name, *clocks[name])}
    return out
