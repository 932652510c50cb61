"""Text in single-stroke letters."""

import numpy as np
import pytest

from controller.errors import ParameterError
from controller.reference.lettering import FIRST, font, joined, strokes


def test_vu_is_a_v_and_a_u_of_the_height() -> None:
    found = strokes("VU", 0.02)
    assert len(found) == 3
    path = joined(found)
    assert path[:, 1].min() == 0.0
    assert path[:, 1].max() == pytest.approx(0.02)
    left, bottom, right = path[:3]
    assert bottom[0] == pytest.approx(0.5 * (left[0] + right[0])), "both sides of the V in one go"
    assert (path[3:, 0] > right[0]).all()
    assert path[3, 1] == path[-1, 1] == pytest.approx(0.02), "the stems of the U"


def test_every_printable_character_has_a_glyph() -> None:
    assert set(font()) == {chr(FIRST + i) for i in range(96)}
    for character in map(chr, range(33, 127)):
        assert all(np.isfinite(stroke).all() for stroke in strokes(character, 0.01))


@pytest.mark.parametrize(("text", "names"), [("a\u03b1", "\u03b1"), ("   ", "nothing to draw")])
def test_what_cannot_be_drawn_is_named(text: str, names: str) -> None:
    with pytest.raises(ParameterError, match=names):
        strokes(text, 0.01)
