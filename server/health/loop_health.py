"""How the loop and the pressure loops did in the last seconds, from every tick: GET /api/health/loop."""

import threading
from typing import Annotated

import numpy as np

from controller.arrays import Array, Rows
from controller.schema.layout import Model, record_dtype
from controller.schema.messages import Telemetry
from server.http.given import given
from server.rig.numbered import Numbered

LOOP_TICKS = 10_000
"""Ticks that the timing is taken from: 10 s at 1 kHz."""
LAG_TICKS = 30_000
"""Ticks that the pressure loops are judged by: 30 s at 1 kHz."""
EDGES = np.concatenate([[0.0], np.geomspace(1e-6, 1e-1, 26)])
"""Edges of the lateness histogram [s]: five bins a decade, and one below a microsecond."""
SAMPLE = 5e-3
"""Time from one sample of the lag fit to the next, as far as whole ticks allow [s]."""
WINDOW = 4
"""Samples over which the fit averages: 20 ms."""
DELAY_MAX_SAMPLES = 20
"""Longest dead time that is tried [samples]: 100 ms."""
QUIET = 5e3
"""A pressure that changes less than this tells nothing about its lag (RMS) [Pa/s]."""
FAITH = 0.5
"""Least share of the pressures' motion that the fitted lag must explain."""


_KEPT = np.dtype(
    [
        (name, record_dtype(Telemetry)[name])
        for name in ("tick", "slot", "t_ns", "lateness_ns", "step_ns", "pressure_cmd", "pressure_meas")
    ]
)


class Spread(Model):
    """A duration over many ticks [s]."""

    median: float
    p99: float
    largest: float


class Lag(Model):
    """The pressure loops as dead time and first-order lag [s]."""

    dead_time: float
    filling: float | None
    """Time constant while the pressure is below the command; null where that was not seen."""
    exhausting: float | None
    """The same above it."""
    explained: float
    """Share of the pressures' motion that these numbers give."""


class LoopHealth(Model):
    """Timing of the last ticks, and the pressure loops' lag."""

    ticks: int
    lost: int
    """Slots without a tick within the same time."""
    edges: list[float]
    """Edges of the lateness histogram [s], one more than counts; the last bin holds everything beyond, too."""
    counts: list[int]
    lateness: Spread | None
    """Wake-up after the deadline; null before the first tick."""
    step: Spread | None
    """Duration of a tick, plant excluded."""
    pressure: Lag | None
    """Null where the pressures moved too little, or not as a lag would have it."""


class LoopWatch:
    """The timing and pressures of the newest ticks. The link's thread adds, any thread judges."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._rows = Numbered(LAG_TICKS, _KEPT)
        self._last: int | None = None

    def add(self, rows: Rows) -> None:
        """Take telemetry rows, oldest first; a rig that restarted begins again."""
        kept = np.empty(len(rows), _KEPT)
        for name in _KEPT.names or ():
            kept[name] = rows[name]
        with self._lock:
            if self._last is not None and kept["tick"][0] <= self._last:
                self._rows.count = 0
            self._rows.add(kept)
            self._last = int(kept["tick"][-1])

    def lateness_p99(self) -> float:
        """Of the newest ticks [s]; nan before the first."""
        return self.lateness((0.99,))[0]

    def lateness(self, quantiles: tuple[float, ...]) -> list[float]:
        """Of the newest ticks [s]; nan before the first."""
        late = self._newest(LOOP_TICKS)["lateness_ns"]
        if not len(late):
            return [float("nan")] * len(quantiles)
        found: list[float] = (1e-9 * np.quantile(late, quantiles)).tolist()
        return found

    def health(self) -> LoopHealth:
        """Judge the newest ticks."""
        return _judge(self._newest(LAG_TICKS))

    def _newest(self, most: int) -> Rows:
        """A copy of the newest rows, oldest first."""
        with self._lock:
            return self._rows.between(max(self._rows.oldest, self._rows.count - most), self._rows.count)


def _judge(rows: Rows) -> LoopHealth:
    recent = rows[-LOOP_TICKS:]
    slots = recent["slot"][-1] - recent["slot"][0] + 1 if len(recent) else 0
    lateness, step = 1e-9 * recent["lateness_ns"], 1e-9 * recent["step_ns"]
    return LoopHealth(
        ticks=len(recent),
        lost=slots - len(recent),
        edges=EDGES.tolist(),
        counts=np.histogram(np.clip(lateness, 0.0, EDGES[-1]), EDGES)[0].tolist(),
        lateness=_spread(lateness),
        step=_spread(step),
        pressure=_pressure_lag(rows) if len(rows) > 1 else None,
    )


def _pressure_lag(rows: Rows) -> Lag | None:
    """The lag by rows (n,), n > 1, of a loop that has its period from its own clock: not every rig's is 1 ms."""
    dt = 1e-9 * float(np.median(np.diff(rows["t_ns"]) / np.diff(rows["slot"])))
    stride = max(1, round(SAMPLE / dt))
    return fitted_lag(rows["pressure_cmd"][::stride], rows["pressure_meas"][::stride], stride * dt)


def fitted_lag(command: Array, measured: Array, h: float) -> Lag | None:
    """Dead time d and time constants of dp/dt = (p_cmd(t - d) - p) / tau [s], by least squares over all chambers.

    `command` and `measured` (n, chambers) [Pa] are samples every `h` [s]. A valve fills and exhausts at its own rates,
    so each sign of the error has a tau of its own; d is the one that leaves least unexplained.
    """
    if len(measured) < 2 * DELAY_MAX_SAMPLES:
        return None
    rate = (measured[WINDOW:] - measured[:-WINDOW])[DELAY_MAX_SAMPLES:] / (WINDOW * h)
    motion = float(np.sum(rate * rate))
    if not motion > rate.size * QUIET**2:
        return None
    wanted, here = _means(command), _means(measured)[DELAY_MAX_SAMPLES:]
    fits = [_slopes(wanted[DELAY_MAX_SAMPLES - d : len(wanted) - d] - here, rate) for d in range(DELAY_MAX_SAMPLES + 1)]
    best = int(np.argmin([rest for _, _, rest in fits]))
    filling, exhausting, rest = fits[best]
    explained = 1.0 - rest / motion
    if explained < FAITH:
        return None
    return Lag(dead_time=best * h, filling=_inverse(filling), exhausting=_inverse(exhausting), explained=explained)


def _slopes(error: Array, rate: Array) -> tuple[float, float, float]:
    """Least squares of rate = slope error, for error > 0 and < 0: both slopes, and the sum of squares that is left."""
    parts = np.maximum(error, 0.0), np.minimum(error, 0.0)
    up, down = (float(np.sum(part * rate)) / max(float(np.sum(part * part)), 1e-9) for part in parts)
    return up, down, float(np.sum((rate - up * parts[0] - down * parts[1]) ** 2))


def _inverse(slope: float) -> float | None:
    return 1.0 / slope if slope > 0.0 else None


def _means(x: Array) -> Array:
    """Means of every WINDOW samples in a row, (n - WINDOW, chambers)."""
    total = np.cumsum(x, axis=0)
    means: Array = (total[WINDOW:] - total[:-WINDOW]) / WINDOW
    return means


def _spread(seconds: Array) -> Spread | None:
    if not len(seconds):
        return None
    median, p99 = np.percentile(seconds, [50, 99])
    return Spread(median=median, p99=p99, largest=seconds.max())


GivenLoop = Annotated[LoopWatch, given(LoopWatch)]
