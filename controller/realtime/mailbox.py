"""The newest whole record, from one writer to the loop: a sequence lock whose reader never waits.

A box is int64 (1 + words,): word 0 counts writes twice (odd while one is under way), the record follows.
"""

from typing import Any

import numpy as np

from controller.arrays import Words
from controller.realtime.compiled import compiled, fence_acquire, fence_release, load_acquire, store_release


def mailbox(dtype: np.dtype[Any]) -> Words:
    """An empty box for one record of `dtype`."""
    return np.zeros(1 + dtype.itemsize // 8, np.int64)


def words(record: np.ndarray) -> Words:
    """The memory of an array of one record as 8-byte words: int64 (itemsize // 8,)."""
    return record.view(np.int64)


@compiled
def post(box: Words, record: Words) -> None:
    """Write the words of one record; only one thread may post into a box at a time."""
    sequence = box[0]
    store_release(box, 0, sequence + 1)
    fence_release()
    for i in range(record.shape[0]):
        box[1 + i] = record[i]
    store_release(box, 0, sequence + 2)


@compiled
def receive(box: Words, seen: int, scratch: Words, record: Words) -> int:
    """Copy a record newer than `seen` into `record` if a whole one is there; returns the sequence number now held.

    A record that is just being written is left for the next call: `record` never holds a mixture.
    """
    sequence = load_acquire(box, 0)
    if sequence == seen or sequence & 1:
        return seen
    for i in range(record.shape[0]):
        scratch[i] = box[1 + i]
    fence_acquire()
    if load_acquire(box, 0) != sequence:
        return seen
    for i in range(record.shape[0]):
        record[i] = scratch[i]
    return int(sequence)
