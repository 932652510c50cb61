"""`tendril benchmark`: measured data of others, beside their own baselines."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from server.cli.typed import commands

if TYPE_CHECKING:
    from controller.research.measured.sets import Row

app = commands(no_args_is_help=True, help=__doc__)
out = Console()
NAMED_MAX = 2
"""Files of a set that are missing and are named; the rest are counted."""


@app.callback()
def group() -> None:
    """Measured data of others, beside their own baselines."""


@app.command()
def real(
    data: Annotated[Path, typer.Option("--data", help="Folder into which the repositories were cloned.")],
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the rows to this file.")] = None,
) -> None:
    """Answer questions about measured data of others, blind (`tendril docs identification`)."""
    from controller.research.measured.real import SETS, benchmark
    from controller.schema.origin import origin
    from controller.system.origin import command_line
    from controller.system.progress import progress
    from server.cli.files import require_file, write_json

    if json_file is not None:
        require_file(json_file)
    with progress(out, "Benchmark") as told:
        rows = benchmark(data, told)
    _show(rows)
    for one in SETS:
        if any(row["missing"] for row in rows if row["set"] == one.name):
            out.print(
                f"{one.name} is to be had from {one.source} (licence: {one.licence})", highlight=False, soft_wrap=True
            )
    if json_file is not None:
        write_json(json_file, {"rows": rows}, origin(command_line()))
        out.print(f"Written: {json_file}", markup=False, soft_wrap=True, highlight=False)


def _show(rows: "Sequence[Row]") -> None:
    from server.cli.tables import empty, number

    for row in rows:
        out.print(f"{row['set']}: {row['question']}, {row['unit']}", style="bold", highlight=False, soft_wrap=True)
        table = empty("", ("", "figure"), {"figure"})
        table.show_header = False
        table.add_row(f"ours, {row['metric']}", number(row["ours"]))
        for name, value in row["baselines"].items():
            table.add_row(name, number(value))
        out.print(table)
        missing = row["missing"]
        for one in missing[:NAMED_MAX]:
            out.print(f"missing: {one}", markup=False, highlight=False, soft_wrap=True)
        if len(missing) > NAMED_MAX:
            out.print(f"missing: {len(missing) - NAMED_MAX} more beside these (--json names them)", soft_wrap=True)
        out.print()
