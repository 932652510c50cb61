"""The newest rows in memory, for a recording that begins before its button was pressed."""

from collections import deque

from controller.arrays import Rows

KEPT = 10_000
"""Rows: 10 s at 1 kHz, some 10 MB."""


class Before:
    """Batches of rows, `most` rows at most, of one boot of the rig. Not thread-safe."""

    def __init__(self, most: int = KEPT) -> None:
        self._batches: deque[Rows] = deque()
        self._most, self._count = most, 0

    def add(self, rows: Rows) -> None:
        """Keep `rows` (n,), n >= 1, which nobody changes any more; rows of an earlier boot are dropped."""
        if self._batches and rows["tick"][0] <= self._batches[-1]["tick"][-1]:
            self._batches.clear()
            self._count = 0
        self._batches.append(rows)
        self._count += len(rows)
        while self._count - len(self._batches[0]) >= self._most:
            self._count -= len(self._batches.popleft())

    def since(self, tick: int) -> list[Rows]:
        """The rows after `tick`, the newest `most` of them, as batches."""
        if not self._count:
            return []
        first = max(tick, int(self._batches[-1]["tick"][-1]) - self._most)
        later = (batch[batch["tick"] > first] for batch in self._batches)
        return [batch for batch in later if len(batch)]
