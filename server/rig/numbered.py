"""The newest rows of a stream, numbered from 0 on, in one array that is made once; and the rows of the loop's slots."""

import numpy as np

from controller.arrays import Rows, Values, Words
from controller.schema.layout import numbers


def in_slots(slots: Words, wanted: Words) -> Words:
    """Which of the rows at `slots` (n,) of the loop's grid is the newest in each of the `wanted` (m,) ones.

    In a slot that was lost it is the last row before, ahead of all rows the first.
    """
    found: Words = np.clip(np.searchsorted(slots, wanted, "right") - 1, 0, None)
    return found


class Numbered:
    """Not thread-safe. A row keeps its number; of those that are gone nothing is told but that they are."""

    def __init__(self, most: int, dtype: "np.dtype[np.void]") -> None:
        self._rows = np.zeros(most, dtype)
        self._numbers = numbers(self._rows)
        self.count = 0
        """The number of the next row."""

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def memory(self) -> Values:
        """All of it, filled or not."""
        return self._numbers

    @property
    def oldest(self) -> int:
        """The number of the oldest row that is kept."""
        return max(0, self.count - len(self._rows))

    def add(self, rows: Rows) -> None:
        """Append (n,) rows, oldest first; of more than there is room for, the newest."""
        new = numbers(rows)[-len(self._rows) :]
        self.count += len(rows)
        at = (self.count - len(new)) % len(self._rows)
        first = min(len(new), len(self._rows) - at)
        self._numbers[at : at + first] = new[:first]
        self._numbers[: len(new) - first] = new[first:]

    def between(self, start: int, stop: int) -> Rows:
        """A copy of the rows [start, stop), all of which are kept; none where stop is not after start."""
        stop = max(start, stop)
        at = start % len(self._rows)
        first = min(stop - start, len(self._rows) - at)
        found = np.concatenate([self._numbers[at : at + first], self._numbers[: stop - start - first]])
        return np.ndarray(stop - start, self._rows.dtype, found)

    def column(self, name: str, start: int, stop: int) -> Values:
        """A copy of one field of the rows [start, stop)."""
        return self._rows[name][np.arange(start, stop) % len(self._rows)]
