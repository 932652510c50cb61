"""A process that fills a ring flat out: every word of row k is k, so a torn row shows. Arguments: path, rows."""

import sys
from pathlib import Path

import numpy as np

from controller.arrays import Words
from controller.realtime.compiled import compiled
from controller.realtime.ring import ROW_WORDS, Ring, ring_push


@compiled
def push_many(header: Words, rows: Words, row: Words, count: int) -> None:
    for k in range(count):
        row[:] = k
        ring_push(header, rows, row)


if __name__ == "__main__":
    ring = Ring(Path(sys.argv[1]), writable=True)
    push_many(ring.header, ring.rows, np.zeros(ROW_WORDS, np.int64), int(sys.argv[2]))
