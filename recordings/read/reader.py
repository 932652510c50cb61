"""Reads a recording back into numpy, whether it was closed or its writer was killed."""

import contextlib
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import reduce
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from controller.arrays import Mask, Values
from controller.errors import RecordingError
from controller.schema.layout import record_dtype
from controller.schema.messages import RigInfo, Telemetry
from controller.schema.modes import Mode
from controller.schema.parameters import Settings
from recordings.format.about import word
from recordings.format.chunks import Batch, Chunks, Part, common, numbers, opened, widened
from recordings.format.messages import Bookmark, Profile
from recordings.format.profiles import SLOW_FIELDS, TICKS
from recordings.format.signals import APPROACH, BACKBONES, BOOKMARKS, GROUPS, MARKERS, Group, flip

T = TypeVar("T")

TENDRIL, CLOCK = "/__properties/tendril", "/__properties/clock"
SCALARS, STRIPS, LOG, MODE = "Scalars:scalars", "LineStrips2D:strips", "/log", "/mode"
DENSE = {group.path: SCALARS for group in GROUPS}
SLOW = {MARKERS: ("markers", SCALARS)} | {path: (field, STRIPS) for path, field in BACKBONES.items()}


class Approaches(NamedTuple):
    """Stretches that lead into a run: first tick and end of each (k, 2), and when that was noted (k,) [s].

    Ticks are those of the boot in which it was noted: another one's begin again.
    """

    ticks: Values
    noted: Values


class Recorded(NamedTuple):
    """What a recording says of itself: who recorded, the settings at the start, how much is kept."""

    info: RigInfo
    settings: Settings
    profile: Profile


def read_rows(path: Path, fields: Collection[str] = ()) -> dict[str, Values]:
    """Recorded telemetry fields (n, ...) in the order of time, in Telemetry's own types and units; all without names.

    `markers`, `backbone` and `twin_backbone` are slower, and so are `profiles.SLOW_FIELDS` in the profile `standard`:
    each comes with `<name>_tick` and `<name>_t_ns` (k,), ticks and times of its values; ticks begin again where the rig
    restarted. `approach` (n,) of bool says which rows lead into a run
    and are no part of it; it is left out where the recording says nothing of that. What is at every tick comes with its
    whole group. A batch that a killed writer left half written is dropped.
    """
    wanted = tuple(group for group in GROUPS if not fields or _holds(group, fields))
    slow = [entity for entity, (field, _) in SLOW.items() if not fields or field in fields]
    last = GROUPS[-1]  # what has its row there has it in all groups
    groups = wanted if last in wanted else (*wanted, last)
    found = _collect(path, [*(group.path for group in groups), TICKS.path, *slow, CLOCK, APPROACH])
    thinned, groups = (wanted, (TICKS,)) if TICKS.path in found else ((), groups)
    origin = int(found[CLOCK][0].column("t_ns_origin").flatten()[0].as_py()) if CLOCK in found else 0
    tables = {group.path: _Table(found.get(group.path, []), SCALARS) for group in groups}
    whole = reduce(common, [table.t for table in tables.values()])
    clock = tables[groups[0].path].only(whole)
    out: dict[str, Values] = {"tick": clock.tick, "t_ns": clock.t + origin}
    for group in groups:
        _spread(tables[group.path].only(whole), group, out)
    if APPROACH in found:
        out["approach"] = in_approach(clock.t * 1e-9, clock.tick, _approaches(found))
    return out | _thinned(found, thinned, origin) | _slow(found, slow, origin)


def _approaches(found: dict[str, list[Batch]]) -> Approaches:
    table = _Table(found[APPROACH], SCALARS)
    return Approaches(table.values(2), table.t * 1e-9)


def _holds(group: Group, fields: Collection[str]) -> bool:
    return any(series.field in fields for series in group.series)


def read_times(path: Path) -> tuple[Values, Values]:
    """Ticks and times since the start [ns] of the rows in the file: (n,), (n,); much cheaper than all rows."""
    found = _collect(path, [GROUPS[-1].path, TICKS.path])
    last = _Table(found.get(TICKS.path if TICKS.path in found else GROUPS[-1].path, []), SCALARS)
    return last.tick, last.t


def read_groups(path: Path, groups: Sequence[Group]) -> dict[str, Part]:
    """The rows of the `groups` that are in the file, by path."""
    found = _collect(path, [group.path for group in groups])
    out = {}
    for group in groups:
        table = _Table(found.get(group.path, []), SCALARS)
        if len(table.t):
            out[group.path] = Part(table.t, table.tick, table.values(len(group.series)))
    return out


def read_approaches(path: Path) -> Approaches | None:
    """What leads into a run; None where the recording says nothing of that."""
    found = _collect(path, [APPROACH])
    return _approaches(found) if found else None


def in_approach(t: Values, tick: Values, approaches: Approaches) -> Mask:
    """Which of the rows at t (n,) [s], rising, and of these ticks (n,) lie in one of the `approaches`."""
    inside = np.zeros(len(tick), bool)
    if not len(tick):
        return inside
    boot = np.cumsum(np.diff(tick, prepend=tick[0] - 1) <= 0)
    noted = boot[np.maximum(0, np.searchsorted(t, approaches.noted, side="right") - 1)]
    for (first, end), its in zip(approaches.ticks, noted, strict=True):
        inside |= (boot == its) & (first <= tick) & (tick < end)
    return inside


def read_start(path: Path) -> int:
    """The wall clock at the first row [ns since 1970]."""
    info, origin = _reading(path, lambda chunks: (about_of(chunks, path).info, clock_origin(chunks)))
    return origin + info.wall_offset_ns


def read_modes(path: Path) -> tuple[Values, Values]:
    """Times since the start [ns] (k,) at which the mode changed, the first row's included, and `Mode` then (k,)."""
    component, modes = "StateChange:state", {word(mode): int(mode) for mode in Mode}
    batches = [batch for batch in _collect(path, [MODE]).get(MODE, []) if component in batch.schema.names]
    t = _joined([batch.column("t").cast("int64").to_numpy() for batch in batches], np.int64)
    words = [word for batch in batches for word in batch.column(component).flatten().to_pylist()]
    order = np.argsort(t, kind="stable")
    return t[order], np.array([modes[word] for word in words], np.int64)[order]


def read_about(path: Path) -> tuple[RigInfo, Settings]:
    """Who recorded, with every parameter, and the settings at the start."""
    about = _reading(path, lambda chunks: about_of(chunks, path))
    return about.info, about.settings


def about_of(chunks: Chunks, path: Path) -> Recorded:
    """What the file `path` says of itself; RecordingError when it is none of ours."""
    said = chunks.properties(TENDRIL, ("info", "settings", "profile"))
    if not {"info", "settings"} <= set(said):
        raise RecordingError(f"{path} is not a recording of Tendril")
    info, settings = RigInfo.model_validate_json(said["info"]), Settings.model_validate_json(said["settings"])
    return Recorded(info, settings, said.get("profile", "full"))


def clock_origin(chunks: Chunks) -> int:
    """The rig's clock at t = 0 [ns]."""
    return int(chunks.properties(CLOCK, ("t_ns_origin",)).get("t_ns_origin", 0))


def read_log(path: Path) -> list[tuple[int, str, str]]:
    """The log's lines as (tick, level, text with its time) in the order of time."""
    lines: list[tuple[int, int, str, str]] = []
    for batch in _collect(path, [LOG]).get(LOG, []):
        t, tick = (batch.column(name).cast("int64").to_pylist() for name in ("t", "tick"))
        level, text = (batch.column(f"TextLog:{name}").flatten().to_pylist() for name in ("level", "text"))
        lines += zip(t, tick, level, text, strict=True)
    return [line[1:] for line in sorted(lines, key=lambda line: line[0])]


def read_bookmarks(path: Path) -> tuple[Bookmark, ...]:
    """What was marked while it was written, with the labels of that moment, in the order of time."""
    found: list[Bookmark] = []
    for batch in _collect(path, [BOOKMARKS]).get(BOOKMARKS, []):
        t, tick = (batch.column(name).cast("int64").to_pylist() for name in ("t", "tick"))
        for at_ns, at, text in zip(t, tick, batch.column("TextLog:text").flatten().to_pylist(), strict=True):
            n, _, label = text.partition(" ")
            found.append(Bookmark(n=int(n), tick=at, t=at_ns * 1e-9, label=label))
    return tuple(sorted(found, key=lambda mark: (mark.t, mark.n)))


class _Table:
    """The batches of one entity as one, in the order of time."""

    def __init__(self, batches: Iterable[Batch], component: str) -> None:
        moving = [batch for batch in batches if "t" in batch.schema.names]
        self.t = _joined([batch.column("t").cast("int64").to_numpy() for batch in moving], np.int64)
        self.tick = _joined([batch.column("tick").to_numpy() for batch in moving], np.int64)
        self._flat = _joined([numbers(batch.column(component)) for batch in moving], np.float64)
        self._rows, self._order = len(self.t), np.argsort(self.t, kind="stable")
        self.t, self.tick = self.t[self._order], self.tick[self._order]

    def values(self, width: int) -> Values:
        """The component's numbers, (rows, width)."""
        return np.asarray(widened(self._flat, self._rows, width)[self._order])

    def only(self, t: Values) -> "_Table":
        """The rows at the times `t`."""
        keep = np.isin(self.t, t, assume_unique=True)
        self.t, self.tick, self._order = self.t[keep], self.tick[keep], self._order[keep]
        return self


def _collect(path: Path, entities: list[str]) -> dict[str, list[Batch]]:
    """One pass through the file: the batches of `entities`."""

    def work(chunks: Chunks) -> dict[str, list[Batch]]:
        found: dict[str, list[Batch]] = defaultdict(list)
        for chunk in chunks.of(entities):
            found[str(chunk.entity_path)].append(chunk.to_record_batch())
        return found

    return _reading(path, work)


def _reading(path: Path, work: Callable[[Chunks], T]) -> T:
    """`work` on the file, on its whole frames where that is written or torn; RecordingError when rerun cannot."""
    with contextlib.suppress(RuntimeError):
        return work(Chunks(path))
    with opened(path) as chunks:
        return work(chunks)


def _slow(found: dict[str, list[Batch]], wanted: Iterable[str], origin: int) -> dict[str, Values]:
    out: dict[str, Values] = {}
    for entity in wanted:
        field, component = SLOW[entity]
        kind = _kind(field)
        table = _Table([batch for batch in found.get(entity, []) if component in batch.schema.names], component)
        width = int(np.prod(kind.shape))
        values = table.values(width).reshape(-1, *kind.shape).astype(kind.base)
        out[field] = flip(values) if component == STRIPS else values
        out |= _clocks([field], table, origin)
    return out


def _thinned(found: dict[str, list[Batch]], groups: Iterable[Group], origin: int) -> dict[str, Values]:
    """SLOW_FIELDS with their ticks and times, from the groups that are written at 100 Hz."""
    out: dict[str, Values] = {}
    for group in groups:
        if slow := SLOW_FIELDS & {series.field for series in group.series}:
            table = _Table(found.get(group.path, []), SCALARS)
            spread: dict[str, Values] = {}
            _spread(table, group, spread)
            out |= {name: spread[name] for name in slow} | _clocks(slow, table, origin)
    return out


def _clocks(names: Iterable[str], table: "_Table", origin: int) -> dict[str, Values]:
    """Ticks and times of the fields `names`, which are in the table."""
    return {key: at for name in names for key, at in ((f"{name}_tick", table.tick), (f"{name}_t_ns", table.t + origin))}


def _spread(table: _Table, group: Group, out: dict[str, Values]) -> None:
    """Put the group's columns into the telemetry fields (rows, ...) of `out` that they belong to."""
    for column, series in zip(table.values(len(group.series)).T, group.series, strict=True):
        kind = _kind(series.field)
        if series.index is None:
            out[series.field] = column.astype(kind.base)
        else:
            out.setdefault(series.field, np.empty((len(column), *kind.shape), kind.base))[:, series.index] = column


def _kind(field: str) -> np.dtype[Any]:
    """Type and shape of a telemetry field."""
    return record_dtype(Telemetry)[field]


def _joined(parts: list[Values], kind: type) -> Values:
    return np.concatenate(parts) if parts else np.empty(0, kind)
