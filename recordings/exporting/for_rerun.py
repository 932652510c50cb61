"""A recording as rerun's viewer shows it beside our page: its theme, and units that people read.

What is recorded stays in SI, bit for bit; this copy of it has no signals that the layout does not plot.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from controller.arrays import Array
from controller.errors import RecordingError
from controller.schema.actuator import Actuator
from recordings.format import plan
from recordings.format.blueprint import APPLICATION, Look, layout, style
from recordings.format.chunks import Chunks, numbers, opened, widened
from recordings.format.signals import GROUPS, Group
from recordings.format.tool import release_streams
from recordings.read.reader import about_of

if TYPE_CHECKING:
    from rerun.chunk import Chunk

UNPLOTTED = "/state"
VALUES = "Scalars:scalars"
TIMEOUT = 120.0
"""Longest wait for the last of it to be written [s]."""


def for_rerun(source: Path, target: Path, dark: bool) -> None:
    """Write it; RecordingError when the recording cannot be read, or the disk takes no more."""
    with opened(source) as chunks:
        actuator = about_of(chunks, source).info.parameters.actuator
        stream = rr.RecordingStream(APPLICATION, recording_id=source.stem)
        try:
            stream.save(target)
            stream.log_file_from_contents(Path("layout.rbl"), layout(actuator.length, Look(dark, units_shown=True)))
            stream.send_chunks(_shown(chunks))
            _restyle(stream, actuator, dark)
            stream.flush(timeout_sec=TIMEOUT)
        except (OSError, RuntimeError) as error:
            raise RecordingError(f"{source.name} cannot be made ready for the viewer: {error}") from error
        finally:
            stream.disconnect()
            del stream
            release_streams()


def _restyle(stream: rr.RecordingStream, actuator: Actuator, dark: bool) -> None:
    """In place of what the recording says of its looks: what is logged last holds."""
    plan.write_scenery(stream, actuator, plan.ON_DARK if dark else plan.ON_LIGHT)
    for group in GROUPS:
        if group.path != UNPLOTTED:
            stream.log(group.path, style(group, units_shown=True), static=True)


def _shown(chunks: Chunks) -> Iterator["Chunk"]:
    scales = {group.path: _scales(group) for group in GROUPS}
    for chunk in chunks.all():
        entity = str(chunk.entity_path)
        if entity == UNPLOTTED:
            continue
        yield chunk if chunk.is_static or entity not in scales else _scaled(chunk, scales[entity])


def _scales(group: Group) -> Array:
    """Factor from SI of each of its series (k,)."""
    return np.array([series.shown[1] for series in group.series])


def _scaled(chunk: "Chunk", scales: Array) -> "Chunk":
    """`chunk` of a group with its values times `scales` (k,)."""
    import pyarrow as pa
    from rerun.chunk import Chunk

    batch = chunk.to_record_batch()
    place = batch.schema.names.index(VALUES)
    column = batch.column(place)
    values = (widened(numbers(column), len(batch), len(scales)) * scales).ravel()
    ends = pa.array(np.arange(len(batch) + 1, dtype=np.int32) * len(scales))
    columns = list(batch.columns)
    columns[place] = pa.ListArray.from_arrays(ends, pa.array(values)).cast(column.type)
    [scaled] = Chunk.from_record_batch(pa.RecordBatch.from_arrays(columns, schema=batch.schema))
    return scaled
