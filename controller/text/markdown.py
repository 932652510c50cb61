"""Tables of the pages in docs/ that follow the code that acts by them: each stands between two marks with its name."""

from collections.abc import Iterable


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table with a line for each of the rows; every line of it ends with a line break."""
    names = list(head)
    first, *others = [f"| {' | '.join(cells)} |\n" for cells in (names, *rows)]
    return "".join([first, f"|{'---|' * len(names)}\n", *others])


def filled(page: str, name: str, text: str) -> str:
    """`page` with `text` between `<!-- name -->` and `<!-- /name -->`; ValueError where they are not there once."""
    before, rest = page.split(f"<!-- {name} -->\n")
    _, after = rest.split(f"<!-- /{name} -->")
    return f"{before}<!-- {name} -->\n{text}<!-- /{name} -->{after}"
