"""The sets of measured data: where each is to be had, what is asked of it, and the rows that come of it."""

import glob
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple, TypedDict

from controller.errors import ParameterError
from controller.schema.origin import sha256

DEEP = 3
"""Folders between the one that is given and a repository."""


DIGITS = 4
"""Behind the point: more are not the same on every processor."""


class Question(NamedTuple):
    """What is asked of a set, and in which figure the answer is."""

    question: str
    metric: str
    unit: str


class Answer(NamedTuple):
    """Ours, and that of each baseline, on the same data."""

    ours: float
    baselines: dict[str, float]


class MeasuredSet(NamedTuple):
    """Public data of one rig of others."""

    name: str
    source: str
    """Where it is to be had."""
    licence: str
    files: tuple[str, ...]
    """Paths inside the repository."""
    questions: tuple[Question, ...]
    answers: Callable[[Mapping[str, Path]], list[Answer]]
    """From the files as they were found, one for each question; DataError where one of them cannot be read."""


class Row(TypedDict):
    """One row of the table, as JSON has it."""

    set: str
    question: str
    metric: str
    unit: str
    ours: float | None
    """None where files are missing."""
    baselines: dict[str, float]
    files: dict[str, str]
    """SHA-256 of each by its path in the repository."""
    missing: list[str]


def find(folder: Path, inner: str) -> Path | None:
    """The file whose path in its repository is `inner`, for repositories as cloned into `folder`."""
    for deep in range(DEEP + 1):
        if found := next(iter(sorted(folder.glob("*/" * deep + glob.escape(inner)))), None):
            return found
    return None


def require_folder(folder: Path) -> None:
    """Raise ParameterError where there is no such folder."""
    if not folder.is_dir():
        raise ParameterError(f"data = {folder} is no folder: give the one into which the repositories were cloned")


def rows(one: MeasuredSet, folder: Path) -> list[Row]:
    """A row for each question, answered where all files are there."""
    found = {inner: find(folder, inner) for inner in one.files}
    there = {inner: path for inner, path in found.items() if path is not None}
    missing = [inner for inner in one.files if inner not in there]
    hashes = {inner: sha256(path) for inner, path in there.items()}
    if missing:
        return [_row(one.name, asked, None, {}, hashes, missing) for asked in one.questions]
    answers = zip(one.questions, one.answers(there), strict=True)
    return [_row(one.name, asked, answer.ours, answer.baselines, hashes, []) for asked, answer in answers]


def _row(
    name: str,
    asked: Question,
    ours: float | None,
    baselines: Mapping[str, float],
    files: dict[str, str],
    missing: list[str],
) -> Row:
    return Row(
        set=name,
        question=asked.question,
        metric=asked.metric,
        unit=asked.unit,
        ours=ours if ours is None else round(ours, DIGITS),
        baselines={which: round(value, DIGITS) for which, value in baselines.items()},
        files=files,
        missing=missing,
    )
