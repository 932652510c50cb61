"""`tendril reproduce` at the command line: progress while it runs, then ours beside the paper's."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from controller.errors import TendrilError
from controller.research.experiments.campaign import Progress as RunProgress
from controller.research.experiments.catalogue import LIVE_PATH
from controller.research.experiments.reproduce import Reproduction, reproduce
from controller.research.experiments.results import Results
from controller.research.report.result_json import result_json
from controller.schema.actuator import PRESETS
from controller.schema.origin import Origin, origin
from controller.simulation.case import Case, Outcome, Setup, parameters_of, settings_of
from controller.simulation.live_path import live_settings
from controller.simulation.run import for_reference
from controller.system.origin import command_line
from controller.system.progress import remaining, say
from server.cli.files import made, require_file, write_json

RECORDINGS = "recordings"
"""Folder of the .rrd files in the report's."""


@dataclass(frozen=True)
class Recorder:
    """Writes the first run of every case into `folder`; called in the worker, where the telemetry is whole."""

    folder: Path
    seed: int
    setup: Setup

    def __call__(self, outcome: Outcome) -> None:
        """RecordingError when the file cannot be written."""
        from recordings.write.run_file import write_run

        case = outcome.case
        if case.seed != self.seed:
            return
        gains = self.setup.gains
        settings = live_settings(case, gains) if case.reference == LIVE_PATH else settings_of(case, gains)
        settings = for_reference(settings, outcome.reference)
        name = f"{case.reference} {case.actuator} {case.law}, seed {case.seed}"
        write_run(outcome.rows, self.path(case), name, parameters_of(case, self.setup), settings)

    def path(self, case: Case) -> Path:
        """The recording of the first run of `case`."""
        return self.folder / f"{case.reference}_{case.actuator}_{case.law}.rrd"

    def clear(self, cases: Iterable[Case]) -> None:
        """Remove what an earlier reproduction left: a run that now fails would seem to have a recording.

        Raises TendrilError for a file that stays.
        """
        for case in cases:
            path = self.path(case)
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise TendrilError(f"{path} cannot be removed: {error.strerror}") from error


def run_reproduce(reproduction: Reproduction, report: Path | None, json_file: Path | None, console: Console) -> None:
    """Run, show, and write what is asked for; TendrilError before the first run if something cannot be written."""
    if json_file is not None:
        require_file(json_file)
    recorder = recorder_in(report, reproduction) if report is not None else None
    with progress(reproduction, console) as told:
        results = reproduce(reproduction, told, recorder)
    from server.cli.research.reproduce_table import show  # it draws, and takes its time to be there: not at the start

    show(results, console)
    for path in deliver(results, report, json_file, console):
        console.print(f"Written: {path}", markup=False, soft_wrap=True, highlight=False)


def recorder_in(report: Path, reproduction: Reproduction) -> Recorder:
    """A recorder of the first seed's runs, in a folder of the report's that is there and writable."""
    recorder = Recorder(made(report / RECORDINGS), min(case.seed for case in reproduction.cases), reproduction.setup)
    recorder.clear(reproduction.cases)
    return recorder


def deliver(results: Results, report: Path | None, json_file: Path | None, console: Console) -> Iterator[Path]:
    """Write what is asked for; each path as soon as it is there."""
    if json_file is not None:
        write_json(json_file, result_json(results), origin_of_results(results))
        yield json_file
    if report is not None:
        from controller.research.report.page import write_report

        yield report / RECORDINGS
        with console.status("Drawing the report ..."):
            page = write_report(results, report)
        yield page


def origin_of_results(results: Results) -> Origin:
    """Every number that the runs have in common, and the actuators of all."""
    setup = results.setup
    return origin(
        command_line(),
        actuators=tuple(PRESETS[name] for name in sorted({row.about.actuator for row in results.rows} & set(PRESETS))),
        settings=setup.gains,
        controller=setup.controller,
        plant=setup.twin,
        seeds=results.seeds,
    )


@contextmanager
def progress(reproduction: Reproduction, console: Console) -> Iterator[RunProgress]:
    """A bar over all runs that names the last one that ended."""
    columns = (
        TextColumn("Running"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        remaining(),
        TextColumn("{task.fields[last]}"),
    )
    first = f"{reproduction.workers} processes start; the first time they compile"
    say(console, f"{reproduction.runs} runs, {first}")
    with Progress(*columns, console=console) as bars:
        task = bars.add_task("", total=reproduction.runs, last=f"{first} ...")

        def told(case: Case) -> None:
            bars.update(task, advance=1, last=f"{case.reference} {case.actuator} {case.law}")

        yield told
