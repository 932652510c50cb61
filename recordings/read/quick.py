"""The quick look at a recording: its main signals as extremes of a few thousand bins, small enough for a page."""

from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydantic import ValidationError

from controller.arrays import Array, Words
from controller.errors import ParameterError
from controller.schema.layout import Model, quantity
from controller.schema.messages import Telemetry
from recordings.format.chunks import Part
from recordings.format.profiles import TICKS
from recordings.format.signals import GROUPS, Series
from recordings.read import prepared
from recordings.read.course import Stretch, at_run_clock, begun, run_clock, stretches
from recordings.read.period import find_phase
from recordings.read.reader import in_approach, read_approaches, read_groups, read_modes

Numbers = list[float | None]
"""What is not a number is null."""

PATHS = ("/tip/x", "/tip/y", "/error", "/pressures", "/u", "/timing")
TRACKS = ("p_ref", "p_meas", "p_hat")
DIGITS = 6
AT_ONCE_MAX = 256 << 20
"""Larger files [B] are read one group after the other: that takes longer, but a fraction of the memory."""
CACHED = 8
"""Some 0.3 MB each, ten times that with the most points; what is prepared beside the data is nearly as quick."""
POINTS = 2000
"""Values of a signal in what is prepared, and unless another number is asked for."""


class QuickSignal(Model):
    """One line of a plot; `values` (n,) in SI units go with `Quick.t`."""

    key: str
    field: str
    index: int | None
    label: str
    unit: str
    values: Numbers


class Track(Model):
    """A path in the plane [m]; x and y (m,) go with `Quick.track_t`."""

    field: str
    x: Numbers
    y: Numbers


class Quick(Model):
    """Times are in seconds since the first row."""

    duration: float
    rows: int
    stretches: list[Stretch]
    """What lies where, in the order of time; none without rows."""
    t: list[float]
    """(n,): every row of a short recording; else two for each bin, which holds the lowest and the highest value."""
    signals: list[QuickSignal]
    track_t: list[float]
    tracks: list[Track]
    period: float | None
    """Of the reference [s]; null when it does not repeat."""
    cycle_start: float
    """When the first whole cycle begins [s]: the same place of the same reference in every recording."""
    cycle_end: float
    """Until when it repeats [s]."""


def quick_look(path: Path, points: int, keys: tuple[str, ...] = ()) -> bytes:
    """`Quick` as JSON, at most `points` values a signal, of the signals `keys` (none: all); kept for the next who asks.

    Raises `RecordingError` when the file cannot be read, `ParameterError` for a key that is none.
    """
    unknown = sorted(set(keys) - {_key(series) for series in _all_series()} - {"error.norm"})
    if unknown:
        raise ParameterError(f"signals = {unknown[0]}: the quick look has no such signal")
    return _quick(path, points, keys, prepared.mark(path))


def prepare(path: Path) -> Quick:
    """The quick look at a closed recording, kept beside its data for the first who asks. RecordingError as above."""
    made_from = prepared.mark(path)
    look = _prepared(path, made_from)
    if look is None:
        look = _look(path, POINTS, ())
        prepared.keep(path, made_from, look.model_dump_json().encode())
    return look


def thinned(values: Array, points: int) -> Array:
    """`values` (n, k) as they are when n <= points; else low and high of each of points/2 bins, (points, k).

    A rising bin shows its low end first, a falling one its high end: else a ramp would look like a saw.
    """
    if len(values) <= points:
        return values
    starts = _starts(len(values), points)
    low, high = np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)
    middle = low + high
    rising = np.vstack([middle[1:2] >= middle[:1], middle[1:] >= middle[:-1]])
    out = np.empty((2 * len(starts), values.shape[1]))
    out[0::2], out[1::2] = np.where(rising, low, high), np.where(rising, high, low)
    return out


@lru_cache(maxsize=CACHED)
def _quick(path: Path, points: int, keys: tuple[str, ...], mark: prepared.Mark) -> bytes:
    """The file's `mark` is part of the key: a recording that grew is read again."""
    look = (_prepared(path, mark) if points == POINTS else None) or _look(path, points, keys)
    signals = [signal for signal in look.signals if not keys or signal.key in keys]
    return look.model_copy(update={"signals": signals}).model_dump_json().encode()


def _prepared(path: Path, mark: prepared.Mark) -> Quick | None:
    """What `prepare` has kept; None where there is none, or none that this version understands."""
    text = prepared.kept(path, mark)
    try:
        return None if text is None else Quick.model_validate_json(text)
    except ValidationError:
        return None


def _look(path: Path, points: int, keys: tuple[str, ...]) -> Quick:
    """From the data; `keys` of the signals, none: all."""
    t, tick, columns = _columns(path)
    picked = _starts(len(t), points) if len(t) > points else np.arange(len(t))
    course = _course(path, t, tick)
    cycle = _cycle(t, columns, course)
    wanted = [series for series in _all_series() if _key(series) in columns and (not keys or _key(series) in keys)]
    return Quick(
        duration=float(t[-1]) if len(t) else 0.0,
        rows=len(t),
        stretches=course,
        t=np.round(_bin_times(t, points), 6).tolist(),
        signals=[_signal(series, columns[_key(series)], points) for series in wanted],
        track_t=np.round(t[picked], 6).tolist(),
        tracks=[_track(name, columns, picked) for name in TRACKS if f"{name}.0" in columns],
        period=cycle.period,
        cycle_start=cycle.start,
        cycle_end=cycle.end,
    )


def _columns(path: Path) -> tuple[Array, Words, dict[str, Array]]:
    """Times [s] and ticks (n,), and each series (n,) by its key; without rows that a killed writer left unwhole."""
    groups = [group for group in GROUPS if group.path in PATHS]
    parts = [[*groups, TICKS]] if path.stat().st_size <= AT_ONCE_MAX else [[group] for group in (TICKS, *groups)]
    found = {entity: table for part in parts for entity, table in read_groups(path, part).items()}
    if TICKS.path in found:  # the profile `standard`: what the viewer plots is at 100 Hz there
        groups, found = [TICKS], {TICKS.path: found[TICKS.path]}
    count = min((len(rows.t) for rows in found.values()), default=0)
    first = next(iter(found.values()), Part(np.zeros(0), np.zeros(0, np.int64), np.zeros(0)))
    columns: dict[str, Array] = {}
    for group in groups:
        if group.path in found:
            values = found[group.path].values[:count]
            columns |= {_key(series): values[:, column] for column, series in enumerate(group.series)}
    if "error.0" in columns:
        columns["error.norm"] = np.hypot(columns["error.0"], columns["error.1"])
    return first.t[:count] * 1e-9, first.tick[:count], columns


def _course(path: Path, t: Array, tick: Words) -> list[Stretch]:
    """What lies where in the rows at t (n,) [s]."""
    if not len(t):
        return []
    since, modes = read_modes(path)
    mode = modes[np.maximum(0, np.searchsorted(since * 1e-9, t, side="right") - 1)] if len(modes) else np.zeros(len(t))
    approaches = read_approaches(path)
    return stretches(t, mode, None if approaches is None else in_approach(t, tick, approaches), begun(path))


class Cycle(NamedTuple):
    """When a reference repeats itself: from the start of a first cycle to the end of what was tracked [s]."""

    period: float | None
    start: float
    end: float


def _cycle(t: Array, columns: dict[str, Array], course: list[Stretch]) -> Cycle:
    """Of the reference on the run's own clock: where it was paused, its path goes on."""
    x, y = columns.get("p_ref.0"), columns.get("p_ref.1")
    clock = run_clock(t, course)
    run = np.isfinite(clock)
    if x is None or y is None or not run.any():
        return Cycle(None, 0.0, 0.0)
    period, start = find_phase(clock[run], x[run], y[run])
    return Cycle(period, at_run_clock(start, course), float(t[run][-1]))


def _all_series() -> list[Series]:
    series = [series for group in GROUPS if group.path in PATHS for series in group.series]
    return [*series, Series("error", None, 0)]


def _key(series: Series) -> str:
    """As the live plots name it: "p_ref.0", "error.norm", "residual"."""
    if series.index is None:
        return "error.norm" if series.field == "error" else series.field
    return f"{series.field}.{series.index}"


def _signal(series: Series, values: Array, points: int) -> QuickSignal:
    return QuickSignal(
        key=_key(series),
        field=series.field,
        index=series.index,
        label=series.label,
        unit=quantity(Telemetry, series.field).unit,
        values=_rounded(thinned(values[:, None], points)[:, 0]),
    )


def _track(name: str, columns: dict[str, Array], picked: Words) -> Track:
    x, y = (_rounded(columns[f"{name}.{axis}"][picked]) for axis in (0, 1))
    return Track(field=name, x=x, y=y)


def _bin_times(t: Array, points: int) -> Array:
    """Where the values of `thinned` stand: a quarter and three quarters into each bin."""
    if len(t) <= points:
        return t
    edges = [*_starts(len(t), points), len(t) - 1]
    return np.array([t[a] + part * (t[b] - t[a]) for a, b in pairwise(edges) for part in (0.25, 0.75)])


def _starts(count: int, points: int) -> Words:
    """First rows of points/2 bins of `count` rows, as equal as they can be."""
    return np.linspace(0, count, points // 2, endpoint=False).astype(np.int64)


def _rounded(values: Array) -> Numbers:
    """To six digits of the largest, for a short text."""
    finite = np.isfinite(values)
    largest = float(np.abs(values[finite]).max(initial=0.0))
    digits = DIGITS - int(np.ceil(np.log10(largest))) if largest > 0 else 0
    return [value if ok else None for value, ok in zip(np.round(values, digits).tolist(), finite.tolist(), strict=True)]
