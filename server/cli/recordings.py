"""The recordings in a folder, without a running server."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console

from controller.errors import RecordingError
from controller.system.origin import command_line
from controller.system.progress import progress
from controller.text.header import LengthUnit, TimeUnit
from server.cli.typed import Comments, RecordingsFolder, commands, refuse_given

if TYPE_CHECKING:
    from recordings.format.messages import Recording
    from recordings.store.store import Store

app = commands(no_args_is_help=True, help=__doc__)
out = Console()

Id = Annotated[str, typer.Argument(help="Id of a recording, as ls shows it.")]
Ids = Annotated[list[str], typer.Argument(help="Ids of recordings, as ls shows them.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")]
Start = Annotated[float | None, typer.Option("--from", help="Begin here [s after the first row].")]
Stop = Annotated[float | None, typer.Option("--to", help="End here [s after the first row].")]
COMPARED_MAX = 4
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


@app.command()
def ls(
    words: Annotated[list[str] | None, typer.Argument(help="Only recordings that have all of these words.")] = None,
    limit: Annotated[int, typer.Option(min=1, help="How many, the newest first.")] = 50,
    folder: RecordingsFolder = None,
    as_json: Json = False,
) -> None:
    """List recordings, the newest first."""
    from recordings.read.query import matching
    from server.cli.recordings_tables import listing

    found = matching(_store(folder).list(), " ".join(words or []))
    if as_json:
        _print_json([one.model_dump(mode="json") for one in found[:limit]])
        return
    out.print(listing(found[:limit]))
    if len(found) > limit:
        out.print(f"{len(found) - limit} older ones are not shown (--limit)", highlight=False)


@app.command()
def show(id: Id, folder: RecordingsFolder = None, as_json: Json = False) -> None:
    """Everything that is known about one recording."""
    from server.cli.recordings_tables import details

    found = _store(folder).find(id)
    if as_json:
        _print_json({**found.model_dump(mode="json"), "origin": _origin([_store(folder).path(id)])})
    else:
        out.print(details(found))


@app.command()
def export(
    context: typer.Context,
    id: Id,
    kind: Annotated[
        Literal["csv", "parquet", "mat", "mcap", "rrd", "path"],
        typer.Option("--format", help="path: t, x, y for `tendril track`."),
    ] = "csv",
    target: Annotated[Path | None, typer.Option("--out", help="File to write; ID.FORMAT without it.")] = None,
    signals: Annotated[str, typer.Option(help="Names of signals or fields, as in p_meas,u_1; all without it.")] = "",
    start: Start = None,
    stop: Stop = None,
    what: Annotated[Literal["p_meas", "p_ref", "marker"], typer.Option(help="Of --format path.")] = "p_meas",
    rod: Annotated[int, typer.Option(min=1, max=10, help="Of --what marker.")] = 10,
    comments: Comments = False,
    folder: RecordingsFolder = None,
) -> None:
    """Write a recording's numbers into a file that other programs read (`tendril docs recordings`)."""
    from controller.schema.origin import comment_lines
    from recordings.exporting.export import By, origin_of
    from recordings.exporting.export import export as write
    from recordings.exporting.table import Choice
    from recordings.exporting.tip_path import Wanted, write_path
    from server.cli.files import require_file

    _refuse_unheard(context, kind, what)
    source = _store(folder).path(id)
    target = target or Path(f"{id}.path.csv" if kind == "path" else f"{id}.{kind}")
    require_file(target)
    if target.exists() and target.samefile(source):
        raise RecordingError(f"{target} is the recording itself: give another file")
    if kind == "path":
        before = comment_lines(origin_of(source, command_line()) if comments else None)
        write_path(source, target, Wanted(what, rod, start, stop), before)
    else:
        names = tuple(filter(None, map(str.strip, signals.split(","))))
        with progress(out, "Exporting") as told:
            write(source, target, kind, Choice(names, start, stop), By(command_line(), comments), told)
    _say(f"Written: {target}, {target.stat().st_size / 1e6:.1f} MB")


@app.command("import")
def import_file(
    file: Annotated[Path, typer.Argument(help="CSV file with columns time, x, y (`tendril docs tables`).")],
    name: Annotated[str | None, typer.Option(help="Of the recording; that of the file without it.")] = None,
    time_unit: Annotated[TimeUnit, typer.Option(help="Where the header names none.")] = "s",
    length_unit: Annotated[LengthUnit, typer.Option(help="Where the header names none.")] = "m",
    folder: RecordingsFolder = None,
) -> None:
    """Make a recording of a path that was measured elsewhere."""
    from controller.reference.path_file import read_samples
    from recordings.importing.tip import import_tip

    with progress(out, "Importing"):
        samples = read_samples(file, {"t": time_unit, "x": length_unit, "y": length_unit})
        found = import_tip(_folder(folder), name or file.stem, samples)
    for note in samples.notes:
        _say(note)
    _say(f"Imported: {found.id}, {found.rows} rows, {found.seconds:.3f} s")


@app.command()
def compare(ids: Ids, folder: RecordingsFolder = None, as_json: Json = False) -> None:
    """Put the figures of up to four recordings side by side."""
    from recordings.store.comparing import compared
    from server.cli.recordings_tables import comparison_table

    if not 2 <= len(ids) <= COMPARED_MAX:
        raise RecordingError(f"{len(ids)} recordings cannot be compared: give 2 to {COMPARED_MAX}")
    with progress(out, "Reading") as told:
        found = compared(_store(folder), ids, told)
    if as_json:
        read = [_store(folder).path(one.recording.id) for one in found]
        _print_json({**{one.recording.id: one.figures for one in found}, "origin": _origin(read)})
    else:
        for place, one in enumerate(found, 1):
            _say(f"{place}: {one.recording.id}, {one.recording.name}")
        out.print(comparison_table(found))


@app.command()
def repair(ids: Annotated[list[str] | None, typer.Argument()] = None, folder: RecordingsFolder = None) -> None:
    """Mend what a killed writer left behind: all such recordings, or those given."""
    store = _store(folder)
    left = []
    with progress(out, "Mending") as told:
        chosen = ids or store.broken()
        for done, id in enumerate(chosen, 1):
            try:
                found = store.repair(id)
                _say(f"{id}: {'mended' if found.recovered else 'whole'}, {found.rows} rows, {found.seconds:.3f} s")
            except Exception as error:  # whatever is wrong with one, the next ones wait for us
                left.append(f"{id}: {error}")
            told(done / len(chosen))
    if left:
        raise RecordingError(f"{len(left)} of {len(chosen)} recordings are not mended: {'; '.join(left)}")


@app.command()
def rm(
    ids: Ids,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")] = False,
    for_good: Annotated[bool, typer.Option("--for-good", help="Do not keep them for 7 days.")] = False,
    folder: RecordingsFolder = None,
) -> None:
    """Delete recordings, which `restore` takes back for 7 days; those with a star stay."""
    store = _store(folder)
    starred_first = sorted((_removable(store, id) for id in ids), key=lambda found: not found.starred)
    for found in starred_first:  # one that is refused is met before any is deleted
        if yes or typer.confirm(f"Delete {found.id} ({found.name}, {found.bytes / 1e6:.1f} MB)?"):
            (store.erase if for_good else store.remove)(found.id)
            _say(f"Deleted: {found.id}")


@app.command()
def restore(ids: Annotated[list[str] | None, typer.Argument()] = None, folder: RecordingsFolder = None) -> None:
    """Take deleted recordings back; without ids, list what can be."""
    from server.cli.recordings_tables import listing

    store = _store(folder)
    if not ids:
        out.print(listing(store.bin.recordings()))
    for id in ids or ():
        store.restore(id)
        _say(f"Restored: {id}")


@app.command()
def play(id: Id, folder: RecordingsFolder = None) -> None:
    """Open a recording in rerun's own viewer; needs a display."""
    from recordings.format import tool

    path = _store(folder).path(id)
    if sys.platform == "linux" and not any(os.environ.get(name) for name in DISPLAYS):
        raise RecordingError("there is no display for rerun's viewer here: open the recording in the page's Review tab")
    with tool.quiet_home() as environment:
        code = subprocess.run(tool.command(str(path)), env=environment, check=False).returncode
    if code:
        raise RecordingError(f"rerun's viewer ended with code {code}")


def _refuse_unheard(context: typer.Context, kind: str, what: str) -> None:
    """ParameterError for an option of `export` that this format has no use for."""
    if kind == "path":
        refuse_given(context, "--format path holds t, x, y of what --what names", "signals")
    else:
        refuse_given(context, f"is for --format path, not {kind}", "what", "rod")
    if what != "marker":
        refuse_given(context, f"is for --what marker, not {what}", "rod")
    if kind not in ("csv", "path"):
        has = "is the recording as it is" if kind == "rrd" else "says its origin by itself"
        refuse_given(context, f"is for --format csv and path; {kind} {has}", "comments")


def _removable(store: "Store", id: str) -> "Recording":
    """The recording `id`, even a damaged one, of which the list alone knows; RecordingError where there is none."""
    try:
        return store.find(id)
    except RecordingError:
        listed = next((one for one in store.list() if one.id == id), None)
        if listed is None:
            raise
        return listed


def _folder(folder: Path | None) -> Path:
    from recordings.store.store import default_folder
    from server.settings import ServerSettings

    return folder or ServerSettings().recordings or default_folder()


def _store(folder: Path | None) -> "Store":
    """Those of a folder that is there; a wrong name makes no new one, and a list leaves no file."""
    from recordings.store.store import Store

    if folder is not None and not folder.is_dir():
        raise RecordingError(f"{folder} is not a folder")
    return Store(_folder(folder), keep_index=False)


def _origin(read: list[Path]) -> dict[str, object]:
    """Of figures that are made of the recordings `read`; the numbers of the rig where it is one that can be read."""
    from controller.schema.origin import hashes, origin
    from recordings.exporting.export import origin_of

    try:
        [only] = read
        found = origin_of(only, command_line())
    except (ValueError, RecordingError):
        found = origin(command_line(), files=hashes(read))
    return found.model_dump(mode="json")


def _print_json(value: object) -> None:
    typer.echo(json.dumps(value, indent=2))


def _say(text: str) -> None:
    out.print(text, markup=False, soft_wrap=True, highlight=False)
