"""A planar limb with nine tags: six that are not seen, from two that are and the direction of the base."""

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.shape import RestingBody, Scatter, estimated, resting_body
from controller.research.measured.sets import Answer, MeasuredSet, Question

FILE = "cpp_examples/real2sim_case/soft_limb_data.csv"
TAGS = range(101, 110)
SEEN = (4, 8)
HIDDEN = (1, 2, 3, 5, 6, 7)
AT_REST = 5
"""First frames, in which nothing is heated: they tell the arc length of each tag and how the limb is bent by itself."""
SCATTER = Scatter(bend=1.0, unexplained=0.1, strain=0.01, point=6e-4)
"""A half bends by a radian, a tenth as much in ways that no muscle explains, chords of tags differ by a hundredth, and
a tag is found to 0.3 pixels of the 540 of the limb."""


def answers(paths: Mapping[str, Path]) -> list[Answer]:
    """Rms over all hidden tags and frames, in percent of the length."""
    frames = _tags(paths[FILE])
    body = resting_body(frames[:AT_REST].mean(axis=0), halves=SEEN[0])
    ways = {"chords": _chords, "cubic": _cubic, "two arcs": _two_arcs, "two arcs from the bent rest": _from_rest}
    ours = [estimated(body, SEEN, P[list(SEEN)], SCATTER)[0] for P in frames]
    baselines = {name: _percent(body, [way(body, P) for P in frames], frames) for name, way in ways.items()}
    return [Answer(_percent(body, ours, frames), baselines)]


def _tags(path: Path) -> Array:
    """Places (n,9,2) in lengths of the limb, from its first tag; frames in which a tag was not found are left out."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            table = list(csv.DictReader(file))
        columns = [[[float(row[f"tagid_{axis}_{tag}"] or "nan") for row in table] for axis in "xy"] for tag in TAGS]
    except (KeyError, TypeError, ValueError, OSError) as error:
        raise DataError(f"{path}: no table with tagid_x_101 to tagid_y_109: {error}") from error
    frames = np.array(columns).reshape(len(TAGS), 2, -1).transpose(2, 0, 1)
    frames = frames[(np.isfinite(frames) & (frames != 0.0)).all(axis=(1, 2))]
    if len(frames) <= AT_REST:
        raise DataError(f"{path}: {len(frames)} frames with all tags are too few")
    frames -= frames[:, :1]
    rest = frames[:AT_REST].mean(axis=0)
    return np.asarray(frames / np.linalg.norm(np.diff(rest, axis=0), axis=1).sum())


def _percent(body: RestingBody, found: list[Array], frames: Array) -> float:
    off = np.linalg.norm(np.array(found)[:, HIDDEN] - frames[:, HIDDEN], axis=2)
    return float(100.0 * np.sqrt(np.mean(off**2)) / body.s[-1])


def _chords(body: RestingBody, P: Array) -> Array:
    seen = [0, *SEEN]
    return np.column_stack([np.interp(body.s, body.s[seen], P[seen, axis]) for axis in (0, 1)])


def _cubic(body: RestingBody, P: Array) -> Array:
    seen = [0, *SEEN]
    first = np.array([np.cos(body.rest[0]), np.sin(body.rest[0])])
    return np.asarray(CubicSpline(body.s[seen], P[seen], bc_type=((1, first), "natural"))(body.s))


def _two_arcs(body: RestingBody, P: Array) -> Array:
    """A circle through the base along its direction and the first seen tag; one that goes on from there to the next."""
    out, angle = np.array(P), float(body.rest[0])
    for begin, end in ((0, SEEN[0]), SEEN):
        chord = P[end] - P[begin]
        turn = np.arctan2(chord[1], chord[0]) - angle
        share = (body.s[begin : end + 1] - body.s[begin]) / (body.s[end] - body.s[begin])
        reach = np.linalg.norm(chord) * share * np.sinc(turn * share / np.pi) / np.sinc(turn / np.pi)
        way = angle + turn * share
        out[begin : end + 1] = P[begin] + reach[:, None] * np.column_stack([np.cos(way), np.sin(way)])
        angle += 2.0 * turn
    return out


def _from_rest(body: RestingBody, P: Array) -> Array:
    """Two arcs, and what they leave of the rest, which ours is given too."""
    return np.asarray(_two_arcs(body, P) + body.places - _two_arcs(body, body.places))


LIMB = MeasuredSet(
    name="planar limb",
    source="github.com/StructuresComp/dismech-rods",
    licence="GPL-3.0",
    files=(FILE,),
    questions=(Question("six hidden tags from two and the base's direction", "rms distance", "% of length"),),
    answers=answers,
)
