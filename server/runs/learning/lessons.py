"""What was learned of each path, in files of the server's state; the planner's process alone reads and writes them.

A path, an arm, a controller and its gains that are not the same to the last bit are another file: nothing that was
learned with others is ever used. Of more than KEPT files the one that was kept longest ago goes.
"""

import hashlib
import io
import json
import logging
import zlib
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from controller.arrays import Array
from controller.reference.learning import Lesson, path_errors, taught, untaught
from controller.schema.parameters import RigParameters
from controller.system.whole_file import read_whole, write_whole
from server.runs.lap import Lap, Order
from server.runs.learning.seen import AGE, P_MEAS, Repeat

KEPT = 200
"""Files at most."""
GAINS = ("controller", "tuning", "law", "sensed", "K_P", "K_I", "K_FF", "K_o", "B_o")
"""Settings with which feedback is another."""
NUMBERS = ("bound", "cutoff", "cutoff_least", "rmse", "repeats")
"""Of a lesson, beside its rows."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Course:
    """What was learned of a path."""

    first: Lesson
    """Of its first lap."""
    later: Lesson
    """Of those after it, which do not begin at rest."""
    errors: tuple[float | None, ...] = ()
    """RMSE of every repeat so far [m], as its result has it; None for one that was broken off."""

    @property
    def laps(self) -> Lesson:
        """For the laps after the first: what that taught, while no other was followed."""
        return self.later if self.later.repeats else self.first


@dataclass(frozen=True)
class Lessons:
    """The files. What cannot be read counts as not learned yet."""

    folder: Path

    def read(self, key: str) -> Course | None:
        """What was learned; None without any, or where it cannot be read."""
        try:
            with np.load(io.BytesIO(read_whole(self._file(key))), allow_pickle=False) as found:
                known = json.loads(str(found["known"]))
                first, later = (_lesson(found[name], known[name]) for name in ("first", "later"))
                course = Course(first, later, tuple(known["errors"]))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, EOFError, BadZipFile, zlib.error) as error:
            log.warning("%s cannot be used, so its path counts as not learned: %s", self._file(key), error)
            return None
        return course

    def keep(self, key: str, course: Course) -> None:
        """Put `course` on the disk; raises OSError."""
        known = {name: _numbers(getattr(course, name)) for name in ("first", "later")} | {"errors": course.errors}
        out, known_json = io.BytesIO(), np.array(json.dumps(known))
        np.savez_compressed(out, known=known_json, first=_rows(course.first), later=_rows(course.later))
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(self._file(key), out.getvalue())
        for old in sorted(self.folder.glob("*.npz"), key=lambda file: file.stat().st_mtime)[:-KEPT]:
            old.unlink()

    def forget(self, key: str) -> bool:
        """Whether there was one, which is no more; raises OSError."""
        there = self._file(key).exists()
        self._file(key).unlink(missing_ok=True)
        return there

    def _file(self, key: str) -> Path:
        return self.folder / f"{key}.npz"


def key_of(order: Order) -> str:
    """Name of the file of what is learned of this path, by this arm, with these gains."""
    lap, rig, settings = order.lap, order.rig, order.settings
    gains = {name: getattr(settings, name) for name in GAINS}
    text = f"{rig.actuator.model_dump_json()} {rig.controller.model_dump_json()} {gains} {lap.kind}"
    return hashlib.sha256(text.encode() + lap.lead.tobytes() + lap.p.tobytes() + lap.u.tobytes()).hexdigest()[:24]


def untaught_course(n: int, rig: RigParameters) -> Course:
    """Before the first repeat of a path of n rows."""
    none = untaught(n, rig.actuator, rig.controller)
    return Course(none, none)


def teach(lessons: Lessons, order: Order, repeat: Repeat) -> None:
    """Learn from a repeat; nothing where what it began with was forgotten meanwhile. Raises OSError."""
    before, lap, dt = repeat.before, order.lap, order.rig.controller.dt
    course = (lessons.read(before.key) if before.errors else None) or untaught_course(len(lap.p), order.rig)
    if course.errors != before.errors:
        return
    first, later = course.first, course.later
    if (seen := repeat.seen) is None:
        first = taught(first, None, dt)
        later = taught(later, None, dt) if later.repeats else later
    else:
        if (error := _error(lap, seen.first, dt)) is None:
            return
        first = taught(first, error, dt)
        if seen.later is not None and (error := _error(lap, seen.later, dt)) is not None:
            later = taught(course.laps, error, dt, laps=True)
    lessons.keep(before.key, Course(first, later, (*before.errors, repeat.rmse)))


def _error(lap: Lap, seen: Array, dt: float) -> Array | None:
    """What a lap left (n,2) [m]; none on the way to another pose, or back, which nobody judges."""
    error = path_errors(lap.p, seen[:, P_MEAS].astype(float), np.nan_to_num(seen[:, AGE].astype(float)), dt)
    return None if error is None else np.where(lap.travel[:, None], 0.0, error)


def _rows(lesson: Lesson) -> Array:
    return np.stack([lesson.next, lesson.best, lesson.left]).astype(np.float32)


def _numbers(lesson: Lesson) -> dict[str, float]:
    return {name: getattr(lesson, name) for name in NUMBERS}


def _lesson(rows: Array, known: dict[str, float]) -> Lesson:
    return Lesson(*rows.astype(float), **known)  # type: ignore[arg-type]
