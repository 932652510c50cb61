"""The outermost layer of an .rrd file: a header of 12 bytes, then frames, each of kind, length and so many bytes.

A writer that is killed or whose disk is full can leave half a frame at the end, and rerun's reader then refuses the
whole file: so the end of the last whole frame is what counts.
"""

import os
import struct
from pathlib import Path
from typing import NamedTuple

from controller.errors import RecordingError

MAGIC = b"RRF2"
HEADER_BYTES = 12
FRAME = struct.Struct("<QQ")
"""Kind and length of the payload, little endian."""

END = 0
"""Kind of the last frame of a closed file; what follows it belongs to the footer."""

COPY_BYTES = 1 << 20


class Extent(NamedTuple):
    """How far an .rrd file goes."""

    length: int
    """Bytes up to the end of the last whole frame; the size of the file when it is closed or not torn."""
    closed: bool
    """It has its proper end: nobody writes it any more, and no writer was killed."""
    frames: int
    """Chunks and a few others."""


def extent(path: Path) -> Extent:
    """How far `path` goes; RecordingError when it is no .rrd file."""
    size, count = path.stat().st_size, 0
    with path.open("rb") as file:
        if file.read(HEADER_BYTES)[:4] != MAGIC:
            raise RecordingError(f"{path.name} is not an .rrd file")
        end = HEADER_BYTES
        while len(head := file.read(FRAME.size)) == FRAME.size:
            kind, length = FRAME.unpack(head)
            if end + FRAME.size + length > size:
                break
            count += 1
            if kind == END:
                return Extent(size, True, count)
            end = file.seek(length, os.SEEK_CUR)
    return Extent(end, False, count)


def whole_length(path: Path) -> int:
    """`extent`'s length."""
    return extent(path).length


def copy_whole(path: Path, target: Path) -> None:
    """Copy `path` up to the end of its last whole frame."""
    left = whole_length(path)
    with path.open("rb") as source, target.open("wb") as copy:
        while left and (part := source.read(min(left, COPY_BYTES))):
            left -= copy.write(part)
