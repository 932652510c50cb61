"""The newest rows of a stream, against a list that keeps them all."""

import numpy as np
import pytest

from server.rig.numbered import Numbered

DTYPE = np.dtype([("tick", "<i8"), ("p", "<f8", (2,))])


def rows(first: int, count: int) -> np.ndarray:
    found = np.zeros(count, DTYPE)
    found["tick"] = np.arange(first, first + count)
    found["p"] = found["tick"][:, None] * [0.5, -1.0]
    return found


@pytest.mark.parametrize("sizes", [[1] * 25, [3, 5, 10, 4], [10, 10, 1], [37], [25, 3], [0, 4, 0]])
def test_whatever_comes_the_newest_are_kept_under_their_numbers(sizes: list[int]) -> None:
    kept = Numbered(10, DTYPE)
    for size in sizes:
        kept.add(rows(kept.count, size))
        assert kept.oldest == max(0, kept.count - 10)
        for start in range(kept.oldest, kept.count + 1):
            for stop in range(start, kept.count + 1):
                assert (kept.between(start, stop) == rows(start, stop - start)).all()
                assert kept.column("tick", start, stop).tolist() == list(range(start, stop))
    assert kept.count == sum(sizes)


def test_what_was_given_out_changes_no_more() -> None:
    kept = Numbered(4, DTYPE)
    kept.add(rows(0, 4))
    found = kept.between(0, 4)
    kept.add(rows(4, 4))
    assert found["tick"].tolist() == [0, 1, 2, 3]
    assert not len(kept.between(6, 5))
