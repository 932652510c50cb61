"""The outermost layer of an .rrd file: a header of 12 bytes, then frames, each of kind, length and bytes.

A writer that is killed or whose disk is full can leave half a frame at the end, and rerun's reader then refuses the
whole file: so the end of the last whole frame is what counts. A power cut can also leave pages of zeros where data did
not reach the disk. Frames are compressed and hold no page of zeros: what comes from the first one on is not whole.
"""

import os
import struct
from pathlib import Path
from typing import NamedTuple

from controller.errors import RecordingError
from controller.system.whole_file import open_regular

MAGIC = b"RRF2"
HEADER_BYTES = 12
FRAME = struct.Struct("<QQ")
"""Kind and length of the payload, little endian."""

END = 0
"""Kind of the last frame of a closed file; what follows it belongs to the footer."""
FOOTER, FOOTER_BYTES = b"RRF2FOOT", 32

COPY_BYTES = 1 << 20
PAGE = 4096


class Extent(NamedTuple):
    """How far an .rrd file goes."""

    length: int
    """Bytes up to the end of the last whole frame; the size of the file when it is closed or not torn."""
    closed: bool
    """It has its proper end: no one writes it any more, and no writer was killed."""
    frames: int
    """Chunks and a few others."""


def extent(path: Path, size: int | None = None) -> Extent:
    """How far `path` goes, of which only the first `size` bytes count; RecordingError when it is no .rrd file."""
    with open_regular(path) as file:
        size, count = os.fstat(file.fileno()).st_size if size is None else size, 0
        if file.read(HEADER_BYTES)[:4] != MAGIC:
            raise RecordingError(f"{path.name} is not an .rrd file")
        end = HEADER_BYTES
        while len(head := file.read(FRAME.size)) == FRAME.size:
            kind, length = FRAME.unpack(head)
            if end + FRAME.size + length > size:
                break
            after = file.seek(length, os.SEEK_CUR)
            if kind == END:
                closed = after + FOOTER_BYTES <= size and FOOTER in file.read(FOOTER_BYTES)
                return Extent(size, True, count + 1) if closed else Extent(end, False, count)
            end, count = after, count + 1
    return Extent(end, False, count)


def whole_length(path: Path) -> int:
    """`extent`'s length."""
    return extent(path).length


def intact_length(path: Path) -> int:
    """The same of a file that a power cut may have torn anywhere; slow, reads all of it."""
    return extent(path, _first_hole(path)).length


def copy_whole(path: Path, target: Path, length: int | None = None) -> None:
    """Copy `path` up to the end of its last whole frame, or up to `length`."""
    left = whole_length(path) if length is None else length
    with open_regular(path) as source, target.open("wb") as copy:
        while left and (part := source.read(min(left, COPY_BYTES))):
            left -= copy.write(part)


def _first_hole(path: Path) -> int:
    """Where the first page of zeros begins; the size of the file without one."""
    zeros, at = bytes(PAGE), 0
    with open_regular(path) as file:
        while part := file.read(COPY_BYTES):
            for page in range(0, len(part), PAGE):
                if part[page : page + PAGE] == zeros[: len(part) - page]:
                    return at + page
            at += len(part)
    return at
