"""What the columns of a table are called, and in which units they are."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from controller.errors import DataError

TimeUnit = Literal["s", "ms", "us", "ns"]
LengthUnit = Literal["m", "cm", "mm", "um", "in"]
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 25.4e-3}
PRESSURE = {"pa": 1.0, "kpa": 1e3, "mpa": 1e6, "mbar": 1e2, "bar": 1e5, "psi": 6894.757293}
NAMES: tuple[tuple[re.Pattern[str], str, Mapping[str, float]], ...] = (
    (re.compile("t|time"), "t", TIME),
    (re.compile(r"[xyz]\d*"), "", LENGTH),
    (re.compile(r"p\d+"), "", PRESSURE),
    (re.compile("id"), "ID", {}),
)
"""Titles in lower case, what they are called here ("" as they are), and what each unit of theirs multiplies."""
UNITS: Mapping[str, Mapping[str, float]] = {"t": TIME, "x": LENGTH, "y": LENGTH}
"""Of the columns of a path, which a person may point out."""
TITLE = re.compile(r"([a-z]+\d*)(?:[\s_]*([\[(/ _])\s*([^\s\])].*?)\s*[\])]?)?")
"""A name alone, or with a unit: x_mm, x mm, x/mm, x [mm], x (mm)."""
LAST = re.compile(r".*?([\[(/ _])\s*([^\s\[\]()/_]+)\s*[\])]?")
"""Any other title with a unit at its end."""
OTHERWISE = {"sec": "s", "seconds": "s", "msec": "ms", "inch": "in", "inches": "in", '"': "in"}
"""Units as others write them."""
MICRO = str.maketrans("\u00b5\u03bc", "uu")
"""Both signs that Unicode has for it."""
TITLE_MAX = 80
"""No longer title is understood."""
TITLES_SHOWN, TITLE_SHOWN = 20, 40
"""Titles of a header that an error quotes, as it may be no header at all, and characters of each."""
COUNTS = ("no", "one", "two", "three")

Places = Mapping[int, str]
"""What the columns of a table without a header are, one letter each, by how many there are."""
Numbers = Mapping[str, int]
"""Which column is t, x or y, counted from 1, as a person says; 0 where there is none."""


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
    line: int = 1
    """Of the header, or of the first row where there is none."""

    def find(self, name: str) -> Column | None:
        """The column `name`, None where it is not there; DataError where it is there twice or in an unknown unit."""
        meant = [column for column in self.columns if column.name == name]
        fitting = [column for column in meant if column.fits]
        if len(fitting) > 1:
            first, second = fitting[0].title, fitting[1].title
            raise DataError(f"{self._place}: the header names {name} twice ({first!r} and {second!r})")
        if fitting or not meant:
            return next(iter(fitting), None)
        raise self._unknown_unit(meant[0])

    def need(self, name: str) -> Column:
        """The column `name`; DataError also where there is none."""
        found = self.find(name)
        if found is None:
            raise DataError(f"{self._place}: column {name} is missing (the header has {self._titles()})")
        return found

    def every(self) -> list[Column]:
        """All columns; DataError for one that has no name, is there twice or is in an unknown unit."""
        counts = Counter(column.name for column in self.columns)
        for column in self.columns:
            if not column.title:
                raise DataError(f"{self._place}: column '' has no name (a comma too many in the header?)")
            if not column.fits:
                raise self._unknown_unit(column)
            if counts[column.name] > 1:
                self.find(column.name)
        return list(self.columns)

    def assigned(self, numbers: Numbers) -> "Header":
        """With t, x and y where a person says they are; DataError for a column that is not there, or is two of them."""
        for name, number in numbers.items():
            if number > len(self.columns):
                raise DataError(f"{self.where}: {name} = column {number}, but there are {len(self.columns)} columns")
        taken = {number - 1: name for name, number in numbers.items() if number}
        if len(taken) < sum(number > 0 for number in numbers.values()):
            said = ", ".join(f"{name} = column {number}" for name, number in numbers.items() if number)
            raise DataError(f"{self.where}: {said}: each must be a column of its own")
        columns = tuple(self._renamed(column, taken.get(column.at), numbers) for column in self.columns)
        return Header(self.where, columns, self.named, self.line)

    def united(self, cells: Sequence[str]) -> "Header | None":
        """With the units that a row below the titles says; None where `cells` are no such row."""
        if len(cells) != len(self.columns):
            return None
        read = [
            (column, _unit("[", cells[column.at].lower().strip("[]() "))) for column in self.columns if column.units
        ]
        if not read or any(column.unit is not None or unit not in column.units for column, unit in read):
            return None
        said = {column.at: replace(column, unit=unit) for column, unit in read}
        return replace(self, columns=tuple(said.get(column.at, column) for column in self.columns))

    def require_alike(self, columns: Sequence[Column]) -> None:
        """DataError where one of `columns` would be in SI, as it names no unit, and one of its kind names another."""
        for column in columns:
            kind = [one for one in columns if one.units is column.units]
            other = next((one for one in kind if one.factor(None) != 1.0), None)
            if column.unit is None and column.units and other is not None:
                raise DataError(
                    f"{self._place}: column {_short(column.title)} names no unit, but {_short(other.title)} is in "
                    f"{other.unit}: write it behind the name, as in {column.name} [{other.unit}]"
                )

    def _renamed(self, column: Column, name: str | None, numbers: Numbers) -> Column:
        if name is not None:
            title = column.title if self.named else name
            return Column(name, title, column.at, UNITS[name], _last_unit(column.title, UNITS[name]))
        return Column("", column.title, column.at, {}, None) if column.name in numbers else column

    @property
    def _place(self) -> str:
        return f"{self.where}, line {self.line}"

    def _unknown_unit(self, column: Column) -> DataError:
        known = f"known for {column.name}: {', '.join(column.units) or 'none'}"
        what = f"column {_short(column.title)!r} has an unknown unit ({known}{self._inches(column)})"
        return DataError(f"{self._place}: {what}")

    def _inches(self, column: Column) -> str:
        """Why `x_in` is none: it may as well be an input."""
        return "; inches are written [in]" if column.unit == NO_INCHES else ""

    def _titles(self) -> str:
        left = len(self.columns) - TITLES_SHOWN
        names = [_short(column.title) or "''" for column in self.columns[:TITLES_SHOWN]]
        return ", ".join(names) + (f", and {left} more" if left > 0 else "")


NO_INCHES = "_in"
"""The unit of a title like `x_in`, which is read as none."""


def titled(titles: Sequence[str], where: str, line: int = 1) -> Header:
    """The columns that a header names."""
    return Header(where, tuple(_column(title, at) for at, title in enumerate(titles)), True, line)


def placed(width: int, places: Places, where: str, line: int = 1) -> Header:
    """The columns of a table without a header; DataError where `places` has none for that `width`."""
    if width not in places:
        wanted = " or ".join(f"{COUNTS[len(names)]} ({', '.join(names)})" for names in places.values())
        needed = f"{wanted} are needed, or a header" if wanted else "a header is needed"
        raise DataError(f"{where}, line {line} has no header and {width} columns: {needed}")
    return Header(where, tuple(_column(name, at) for at, name in enumerate(places[width])), False, line)


def untitled(width: int, where: str, line: int = 1) -> Header:
    """Columns of which nothing is known but their number."""
    return Header(where, tuple(Column("", f"column {at + 1}", at, {}, None) for at in range(width)), False, line)


def _column(title: str, at: int) -> Column:
    """Which column a title like "x", "X_mm", "x [mm]" or "time (s)" means."""
    match = TITLE.fullmatch(title.lower()) if len(title) <= TITLE_MAX else None
    for pattern, name, units in NAMES if match else ():
        if match and pattern.fullmatch(match[1]):
            return Column(name or match[1], title, at, units, match[2] and _unit(match[2], match[3]))
    return Column(title.lower(), title, at, {}, None)


def _unit(mark: str, text: str) -> str:
    """The unit that `text` behind `mark` names; as it is where it names none."""
    plain = text.translate(MICRO)
    unit = OTHERWISE.get(plain, plain)
    return NO_INCHES if plain == "in" and mark in " _" else unit


def _last_unit(title: str, units: Mapping[str, float]) -> str | None:
    """The one of `units` that any title ends with."""
    match = LAST.fullmatch(title.lower()) if len(title) <= TITLE_MAX else None
    unit = _unit(match[1], match[2]) if match else None
    return unit if unit in units else None


def _short(title: str) -> str:
    return title[:TITLE_SHOWN]
