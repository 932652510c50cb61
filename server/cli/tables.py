"""Tables at the terminal."""

from collections.abc import Collection, Sequence

from rich.markup import escape
from rich.table import Table

BIG = 1000.0
"""From here on a number has no digits behind the point."""


def empty(title: str, heads: Sequence[str], numbers: Collection[str]) -> Table:
    """A table without lines; `numbers` are the heads of columns that are flush right."""
    table = Table(title=escape(title), title_justify="left", box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for head in heads:
        table.add_column(escape(head), justify="right" if head in numbers else "left", no_wrap=True)
    return table


def number(value: float | None) -> str:
    """Three digits, or all before the point; "-" for none."""
    if value is None:
        return "-"
    return f"{value:.0f}" if abs(value) >= BIG else f"{value:#.3g}".rstrip(".")
