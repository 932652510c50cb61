"""The chunks of an .rrd file, one after the other: no more than one of them has to be in memory."""

import tempfile
import warnings
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from controller.arrays import Values
from controller.errors import RecordingError
from recordings.format import frames

if TYPE_CHECKING:
    from rerun.chunk import Chunk

# A file that is not closed is readable all the same. Said once for all threads: a context manager is not safe in them.
warnings.filterwarnings("ignore", "RRD file has no footer")

Batch = Any
"""A pyarrow RecordBatch (pyarrow has no types)."""
INDEXED_MAX = 50_000
"""With more chunks a file's index would take much memory (3 kB each): all of them are read in turn instead."""


@dataclass(frozen=True)
class Part:
    """Rows of one entity: times `t` (n,) since the start [ns], ticks (n,) and numbers (n, width)."""

    t: Values
    tick: Values
    values: Values

    def pick(self, rows: Values | slice) -> "Part":
        """A copy of some rows, which does not hold the others in memory."""
        return Part(*(np.array(values[rows]) for values in (self.t, self.tick, self.values)))


class Chunks:
    """The chunks of one file, as often as they are asked for, in one and the same order.

    In a closed and compacted file chunks of other entities are not even read.
    """

    def __init__(self, path: Path) -> None:
        """RuntimeError of rerun when `path` cannot be read."""
        from rerun.chunk import RrdReader  # a server only passes the order on

        reader = RrdReader(path)
        extent = frames.extent(path)
        self._source: Any = reader.store() if extent.closed and extent.frames <= INDEXED_MAX else reader

    def of(self, entities: list[str]) -> Iterator["Chunk"]:
        """The chunks of `entities`."""
        return iter(self._source.stream().filter(content=entities))

    def all(self) -> Iterator["Chunk"]:
        """All of them."""
        return iter(self._source.stream())

    def properties(self, entity: str, names: Collection[str]) -> dict[str, Any]:
        """The values of `names` that `entity` has; they stand at the beginning, so the rest is read only for want."""
        said: dict[str, Any] = {}
        for chunk in self.of([entity]):
            batch = chunk.to_record_batch()
            said |= {name: batch.column(name).flatten()[0].as_py() for name in names if name in batch.schema.names}
            if len(said) == len(names):
                break
        return said

    def parts(self, components: Mapping[str, str]) -> Iterator[tuple[str, Part]]:
        """The chunks of the entities that are keys, each as the numbers of the component that is its value."""
        for chunk in self.of([*components]):
            entity = str(chunk.entity_path)
            batch = chunk.to_record_batch()
            if "t" in batch.schema.names and components[entity] in batch.schema.names:
                yield entity, part(batch, components[entity])


def part(batch: Batch, component: str) -> Part:
    """A chunk's times, ticks and numbers."""
    t, tick = batch.column("t").cast("int64").to_numpy(), batch.column("tick").to_numpy()
    values = numbers(batch.column(component))
    return Part(t, tick, values.reshape(len(t), -1))


def numbers(column: Any) -> Values:
    """All numbers of nested lists, flat."""
    while hasattr(column.type, "value_type"):
        column = column.flatten()
    return np.asarray(column.to_numpy(zero_copy_only=False))


def widened(flat: Values, rows: int, width: int) -> Values:
    """The numbers of `rows` as (rows, width): series that an older version did not write are zero."""
    values = flat.reshape(rows, -1) if rows else flat.reshape(0, width)
    return np.pad(values, ((0, 0), (0, max(0, width - values.shape[1]))))


def common(a: Values, b: Values) -> Values:
    """The times in both `a` (n,) and `b` (m,), each rising."""
    return a if np.array_equal(a, b) else np.intersect1d(a, b, assume_unique=True)  # numpy's unique takes seconds


@contextmanager
def settled(path: Path) -> Iterator[Path]:
    """`path`; where it is not closed, a copy of its whole frames instead, to which no writer adds any.

    RecordingError when it is no .rrd file.
    """
    if frames.extent(path).closed:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="tendril-whole-") as folder:
        whole = Path(folder, path.name)
        frames.copy_whole(path, whole)
        yield whole


@contextmanager
def opened(path: Path) -> Iterator[Chunks]:
    """The chunks of `path`, closed or not; RecordingError when rerun cannot read them."""
    with settled(path) as whole:
        try:
            yield Chunks(whole)
        except RuntimeError as error:
            raise RecordingError(f"{path.name} cannot be read: {error}") from error
