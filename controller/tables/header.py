"""What the columns of a table are called, and in which units they are."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from controller.errors import DataError

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
PRESSURE = {"pa": 1.0, "kpa": 1e3}
NAMES: tuple[tuple[re.Pattern[str], str, Mapping[str, float]], ...] = (
    (re.compile("t|time"), "t", TIME),
    (re.compile(r"[xyz]\d*"), "", LENGTH),
    (re.compile(r"p\d+"), "", PRESSURE),
    (re.compile("id"), "ID", {}),
)
"""Titles in lower case, what they are called here ("" as they are), and what each unit of theirs multiplies."""
TITLE = re.compile(r"([a-z]+\d*)(?:[\s_]*[\[(/ _]\s*([^\s\])].*?)\s*[\])]?)?")
"""A name alone, or with a unit: x_mm, x mm, x/mm, x [mm], x (mm)."""
TITLE_MAX = 80
"""No longer title is understood."""
TITLES_SHOWN, TITLE_SHOWN = 20, 40
"""Titles of a header that an error quotes, as it may be no header at all, and characters of each."""
COUNTS = ("no", "one", "two", "three")

Places = Mapping[int, str]
"""What the columns of a table without a header are, one letter each, by how many there are."""


@dataclass(frozen=True)
class Column:
    """One column of a table."""

    name: str
    """t, x, y, z, x1, .., p1, .., ID; any other title as it is, in lower case."""
    title: str
    """As the header has it; the name where there is none."""
    at: int
    units: Mapping[str, float]
    """In which it may be, the SI unit first; empty for what has none."""
    unit: str | None
    """What the header says; None where it says nothing."""

    @property
    def fits(self) -> bool:
        """Whether its unit, if there is one, is known."""
        return self.unit is None or self.unit in self.units

    def factor(self, unit: str | None) -> float:
        """What makes SI of it; `unit` holds where the header names none, and without that it is in SI."""
        stated = self.unit or unit
        return 1.0 if stated is None else self.units[stated]


@dataclass(frozen=True)
class Header:
    """The columns of one table."""

    where: str
    """What errors call the table."""
    columns: tuple[Column, ...]
    named: bool
    """False: there is no header, and the columns are known by their places."""

    def find(self, name: str) -> Column | None:
        """The column `name`, None where there is none; DataError where it is there twice or in an unknown unit."""
        meant = [column for column in self.columns if column.name == name]
        fitting = [column for column in meant if column.fits]
        if len(fitting) > 1:
            first, second = fitting[0].title, fitting[1].title
            raise DataError(f"{self.where}: the header names {name} twice ({first!r} and {second!r})")
        if fitting or not meant:
            return next(iter(fitting), None)
        raise self._unknown_unit(meant[0])

    def need(self, name: str) -> Column:
        """The column `name`; DataError also where there is none."""
        found = self.find(name)
        if found is None:
            raise DataError(f"{self.where}: column {name} is missing (the header has {self._titles()})")
        return found

    def every(self) -> list[Column]:
        """All columns; DataError for one that has no name, is there twice or is in an unknown unit."""
        counts = Counter(column.name for column in self.columns)
        for column in self.columns:
            if not column.title:
                raise DataError(f"{self.where}: column '' has no name (a comma too many in the header?)")
            if not column.fits:
                raise self._unknown_unit(column)
            if counts[column.name] > 1:
                self.find(column.name)
        return list(self.columns)

    def _unknown_unit(self, column: Column) -> DataError:
        known = f"known for {column.name}: {', '.join(column.units) or 'none'}"
        return DataError(f"{self.where}: column {_short(column.title)!r} has an unknown unit ({known})")

    def _titles(self) -> str:
        left = len(self.columns) - TITLES_SHOWN
        names = [_short(column.title) for column in self.columns[:TITLES_SHOWN]]
        return ", ".join(names) + (f", and {left} more" if left > 0 else "")


def titled(titles: Sequence[str], where: str) -> Header:
    """The columns that a header names."""
    return Header(where, tuple(_column(title, at) for at, title in enumerate(titles)), True)


def placed(width: int, places: Places, where: str) -> Header:
    """The columns of a table without a header; DataError where `places` has none for that `width`."""
    if width not in places:
        wanted = " or ".join(f"{COUNTS[len(names)]} ({', '.join(names)})" for names in places.values())
        needed = f"{wanted} are needed, or a header" if wanted else "a header is needed"
        raise DataError(f"{where} has no header and {width} columns: {needed}")
    return Header(where, tuple(_column(name, at) for at, name in enumerate(places[width])), False)


def _column(title: str, at: int) -> Column:
    """Which column a title like "x", "X_mm", "x [mm]" or "time (s)" means."""
    match = TITLE.fullmatch(title.lower()) if len(title) <= TITLE_MAX else None
    for pattern, name, units in NAMES if match else ():
        if match and pattern.fullmatch(match[1]):
            return Column(name or match[1], title, at, units, match[2])
    return Column(title.lower(), title, at, {}, None)


def _short(title: str) -> str:
    return title[:TITLE_SHOWN]
