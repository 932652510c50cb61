"""Text in single-stroke letters: Hershey's Roman Simplex."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError

FONT = Path(__file__).parent / "data" / "roman_simplex.jhf"
FIRST = 32
"""Code of the first character of the font."""
BASE, CAPITAL = 9, 21
"""Height of the base line, downwards from the font's origin, and of a capital, in the font's units."""


class Glyph(NamedTuple):
    """One character, in the font's units, y upwards from the base line."""

    width: int
    strokes: tuple[Array, ...]
    """Each (n, 2), from the character's left edge."""


def strokes(text: str, height: float) -> list[Array]:
    """Strokes (n, 2) [m] of one line of text with capitals so high [m], its base line from the origin to the right.

    Raises ParameterError for a character that the font has not, and for a text without any stroke.
    """
    found: list[Array] = []
    at = np.zeros(2)
    for character in text:
        if character not in font():
            raise ParameterError(f"text = {text[:60]!r}: there is no letter for {character!r}")
        glyph = font()[character]
        found += [(stroke + at) * (height / CAPITAL) for stroke in glyph.strokes]
        at[0] += glyph.width
    if not found:
        raise ParameterError(f"text = {text[:60]!r} has nothing to draw")
    return found


def in_turn(parts: list[Array]) -> list[Array]:
    """All `parts` (n, 2), each from its end that is nearer to where the one before ends."""
    found = parts[:1]
    for part in parts[1:]:
        ends = np.linalg.norm(part[[0, -1]] - found[-1][-1], axis=1)
        found.append(part if ends[0] <= ends[1] else part[::-1])
    return found


def joined(parts: list[Array]) -> Array:
    """One path (n, 2) through all `parts` `in_turn`, without points twice in a row."""
    path = np.vstack(in_turn(parts))
    moved: Array = path[np.concatenate([[True], (np.diff(path, axis=0) != 0.0).any(axis=1)])]
    return moved


@cache
def font() -> dict[str, Glyph]:
    """All characters of the font."""
    lines = [line for line in FONT.read_text("ascii").splitlines() if not line.startswith("#")]
    return {chr(FIRST + i): _glyph(line[8:]) for i, line in enumerate(lines)}


def _glyph(pairs: str) -> Glyph:
    """A character from its edges and strokes."""
    left, right = (ord(letter) - ord("R") for letter in pairs[:2])
    parts = [part for part in _strokes(pairs[2:]) if len(part) > 1]
    return Glyph(right - left, tuple(np.array(part, float) - (left, 0) for part in parts))


def _strokes(pairs: str) -> list[list[tuple[int, int]]]:
    """Points of each stroke; " R" begins another."""
    found: list[list[tuple[int, int]]] = [[]]
    for x, y in zip(pairs[::2], pairs[1::2], strict=True):
        if x + y == " R":
            found.append([])
        else:
            found[-1].append((ord(x) - ord("R"), BASE - (ord(y) - ord("R"))))
    return found
