"""The documents that messages cite: beside the sources of a clone, within an installed package."""

from importlib.resources import files
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markdown import Markdown

from controller.system.origin import ROOT

out = Console()


def folder() -> Path:
    """Where the documents are."""
    return ROOT / "docs" if (ROOT / "pyproject.toml").exists() else Path(str(files("server"))) / "docs"


def documents() -> dict[str, Path]:
    """Each by its name, as `tendril docs` takes it; beside that of the examples they lie."""
    pages = {path.stem: path for path in folder().glob("*.md")}
    return dict(sorted((pages | {"examples": folder() / "examples" / "README.md"}).items()))


def heading(path: Path) -> str:
    """Of a document."""
    return path.read_text().split("\n", 1)[0].lstrip("# ")


def docs(
    name: Annotated[str | None, typer.Argument(help="Which one; all are listed without it.")] = None,
    path: Annotated[bool, typer.Option("--path", help="Say only where it lies.")] = False,
) -> None:
    """Read a document, the ones that messages and help name among them."""
    known = documents()
    if name is None:
        width = max(map(len, known), default=0)
        for one, file in known.items():
            out.print(
                file if path else f"{one:{width}}  {heading(file)}", markup=False, highlight=False, soft_wrap=True
            )
        return
    if name not in known:
        raise typer.BadParameter(f"{name!r} is none of {', '.join(known)}", param_hint="NAME")
    if path:
        out.print(known[name], markup=False, highlight=False, soft_wrap=True)
        return
    text = Markdown(known[name].read_text())
    if not out.is_terminal:
        out.print(text)
        return
    with out.pager(styles=True):
        out.print(text)
