"""From files of measured data to one actuator; a file says by its header what it can tell (docs/identification.md)."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from controller.errors import DataError, ParameterError, TendrilError, sentence
from controller.research.identification.fit import Estimate, Fit
from controller.research.identification.motion.damping_fit import FreeDecay, fit_damping, given_damping
from controller.research.identification.motion.decays import Decay, decays_in, is_decay, long_ones
from controller.research.identification.motion.modal_fit import fit_modes
from controller.research.identification.poses import is_static, read_poses
from controller.research.identification.report.report import number_text, report_page
from controller.research.identification.statics import fit_statics
from controller.research.identification.tables import MeasuredTable, read_measured
from controller.schema.actuator import Actuator, by_joints, write_actuator
from controller.schema.origin import hashes, origin


@dataclass(frozen=True)
class IdentificationTask:
    """What a user asks for."""

    data: tuple[Path, ...]
    base: Actuator
    """Everything that the data do not say is taken from here."""
    ids: str | None = None
    profile: str = "auto"
    robust: bool = False
    zeta: float | None = None
    """Damping ratio of the first mode, measured otherwise than by the data."""
    command: str = "tendril identify"
    """As it was typed."""


def identify(task: IdentificationTask) -> list[Fit]:
    """The fits that the data of `task` allow, each upon the one before: the last one's actuator has them all."""
    tables = [read_measured(path) for path in task.data]
    statics, decays = [t for t in tables if is_static(t)], [t for t in tables if is_decay(t)]
    _refuse(tables, statics, decays, task)
    fits: list[Fit] = []
    for table in statics:
        with _naming(table.path):
            table.need_rows(1, "a static test")
            fits.append(fit_statics(read_poses(table, task.base), task.base, task.profile, robust=task.robust))
    base = by_joints(task.base)
    for table in decays:
        with _naming(table.path):
            chosen = long_ones(decays_in(table, task.ids), "fit", table.path)
            fits += [fit_damping(outermost(chosen), fits[-1].actuator)] if fits else decay_fits(chosen, base)
    if task.zeta is not None:
        fits.append(given_damping(task.zeta, fits[-1].actuator))
    return fits


def decay_fits(decays: Sequence[Decay], base: Actuator) -> list[Fit]:
    """What decays say without a static test: of several bodies all but the scale, of one body its damping."""
    if decays[0].points.shape[1] > 1:
        return [fit_modes(decays, base)]
    return [fit_damping(outermost(decays), base)]


def outermost(decays: Sequence[Decay]) -> list[FreeDecay]:
    """The motion of the body that is farthest out."""
    return [FreeDecay(f"ID {one.id}", one.t, one.points[:, -1]) for one in decays]


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Put the file's name before an error that does not have it."""
    try:
        yield
    except DataError as error:
        if str(path) in str(error):
            raise
        raise DataError(f"{path}: {error}") from error


def finished(fits: Sequence[Fit], out: Path) -> Actuator:
    """The actuator of the last fit, named after its file; ParameterError names the bound that it breaks."""
    name = re.sub(r"[^\w .+-]", "-", out.stem)[:40]
    try:
        return Actuator.model_validate(fits[-1].actuator.model_dump() | {"name": name})
    except ValidationError as error:
        raise ParameterError(f"the identified actuator is out of bounds: {sentence(error)}") from error


def save(task: IdentificationTask, fits: Sequence[Fit], out: Path, report: Path | None) -> None:
    """Write the actuator file and, if asked for, the report."""
    if out.suffix != ".toml":
        raise ParameterError(f"out = {str(out)!r} does not end in .toml")
    actuator = finished(fits, out)
    try:
        write_actuator(actuator, out, _remark(task, fits))
        if report is not None:
            page = report_page(f"Identification of {actuator.name}", _about(task), fits, out.read_text())
            report.write_text(page)
    except OSError as error:
        raise TendrilError(f"{error.filename} cannot be written: {error.strerror}") from error


def _refuse(
    tables: Sequence[MeasuredTable],
    statics: Sequence[MeasuredTable],
    decays: Sequence[MeasuredTable],
    task: IdentificationTask,
) -> None:
    for table in tables:
        if not (is_static(table) or is_decay(table)):
            raise DataError(
                f"{table.path}: neither p1 (a static test) nor ID (free decays) is in the header "
                f"({', '.join(table.columns)})"
            )
    for kind, found in (("static tests", statics), ("free decays", decays)):
        if len(found) > 1:
            raise DataError(f"{found[1].path}: {kind} of one actuator belong in one file, {found[0].path} has some")
    if task.zeta is not None and decays:
        raise DataError(f"zeta = {task.zeta:g}: {decays[0].path} has free decays, which tell it; leave one of both out")
    if task.robust and not statics:
        raise DataError(f"robust: {task.data[0]} has no static test, whose values it weighs")
    if task.ids is not None and not decays:
        raise DataError(f"ids = {task.ids!r}: {task.data[0]} has no free decays to choose from")


def _about(task: IdentificationTask) -> str:
    ids = f", IDs {task.ids}" if task.ids else ""
    return f"Data: {', '.join(path.name for path in task.data)}{ids}. Based on actuator {task.base.name}. SI units."


def _remark(task: IdentificationTask, fits: Sequence[Fit]) -> str:
    made = origin(task.command, files=hashes(task.data))
    lines = [
        f"Tendril {made.version}, commit {made.commit or 'unknown'}, {made.date.isoformat()}: {made.command}",
        *(f"SHA-256 of {name}: {digest}" for name, digest in made.files.items()),
    ]
    lines += [_about(task), *(_line(one) for fit in fits for one in fit.parameters)]
    return "\n".join(lines)


def _line(one: Estimate) -> str:
    half = (one.high - one.low) / 2
    interval = f" ({number_text(one.low, half)} .. {number_text(one.high, half)})" if half > 0 else ""
    return f"{one.name} = {number_text(one.value, half)}{interval} {one.unit if one.unit != '1' else ''}".rstrip()
