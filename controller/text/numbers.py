"""From the cells of a table to their numbers."""

import math
import re

from controller.errors import DataError
from controller.text.lines import Row

MARKS = {",": "comma", ".": "point"}
"""What may part the decimals."""
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
"""A number that may be of thousands as well as of thousandths."""
UNGROUPED = re.compile(r"[+-]?[1-9]\d{0,2}")
"""What may stand beside numbers of thousands."""
MINUS = "\N{MINUS SIGN}"
QUOTED = 60
"""Characters of a wrong cell that an error quotes."""


def is_number(cell: str) -> bool:
    """Whether `cell` is meant to be a number, finite or not."""
    try:
        _value(cell)
    except ValueError:
        return False
    return True


class Cells:
    """Reads the cells of one table. DataError names line, column and value of the first that is not a finite number."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._mark, self._marked = "", ""
        """The first decimal mark, and where it stands."""
        self._delimiter = ""
        """What parts the cells of the row with the first mark."""
        self._all_grouped = True
        """Whether every mark so far may part thousands."""
        self._grouped: set[int] = set()
        self._ungrouped: set[int] = set()
        """Columns that have such numbers."""

    def read(self, row: Row, at: int, title: str) -> float:
        """The number in cell `at`, whose column is called `title`."""
        cell = row.cells[at]
        try:
            value = _value(cell)
        except ValueError:
            what = f"= {cell[:QUOTED]!r} is not a number" if cell else "is empty"
            raise DataError(f"{self._where}, line {row.line}: {title} {what}") from None
        if not math.isfinite(value):
            raise DataError(f"{self._where}, line {row.line}: {title} = {cell[:QUOTED]} is not finite")
        mark = next((one for one in MARKS if one in cell), None)
        if mark is not None:
            self._look_at_mark(mark, row, at, f"{title} = {cell[:QUOTED]!r}")
        elif self._all_grouped and UNGROUPED.fullmatch(cell):
            self._ungrouped.add(at)
        return value

    def _look_at_mark(self, mark: str, row: Row, at: int, told: str) -> None:
        """DataError where both points and commas occur: either may part thousands."""
        if not self._mark:
            self._mark, self._marked, self._delimiter = mark, f"line {row.line}: {told}", row.delimiter
        if mark != self._mark:
            has = f"has a decimal {MARKS[mark]}, but a {MARKS[self._mark]} is in {self._marked}"
            raise DataError(f"{self._where}, line {row.line}: {told} {has}")
        if self._all_grouped:
            self._all_grouped = GROUPED.fullmatch(row.cells[at]) is not None
            self._grouped.add(at)

    def require_sure(self) -> None:
        """DataError where every mark of the table may part thousands as well as decimals.

        A comma may where no semicolon parts the cells. Any mark may in a column where it is not in all numbers, as in
        998 and 1.002; only a point between commas may not.
        """
        bare_comma = self._mark == "," and self._delimiter != ";"
        point_between_commas = self._mark == "." and self._delimiter == ","
        mixed = bool(self._grouped & self._ungrouped) and not point_between_commas
        if not self._mark or not self._all_grouped or not (bare_comma or mixed):
            return
        remedy = "write decimal points, or part the cells by semicolons" if bare_comma else "write thousands without it"
        raise DataError(
            f"{self._where}, {self._marked} may be thousands or have a decimal {MARKS[self._mark]}: {remedy}"
        )


def _value(cell: str) -> float:
    """ValueError unless it is a number; Python's own 1_000 is not."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell.replace(",", ".").replace(MINUS, "-"))
