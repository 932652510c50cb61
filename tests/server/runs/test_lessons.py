"""What is kept of a path that was learned, and when it is used."""

import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from controller.assembly.controllers.registry import with_controller
from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.reference.learning import taught
from controller.reference.library import reference
from controller.schema.actuator import PRESETS
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.parameters import RigParameters, Settings
from server.runs.ahead import corrections, with_learned
from server.runs.lap import Leg, Order, Place
from server.runs.laps import first_leg, lap_of, next_leg
from server.runs.learning.lessons import KEPT, Course, Lessons, key_of, teach, untaught_course
from server.runs.learning.seen import Repeat, Seen
from server.runs.messages import Learned

RIG = RigParameters()
SETTINGS = with_controller(Settings(), "preview")
REST = np.zeros(2)
DT = RIG.controller.dt
CIRCLE = reference("circle_1hz", RIG.actuator, RIG.controller)
ONCE = Order(lap_of(CIRCLE, RIG, 1), 1, RIG, SETTINGS, "on")
THRICE = Order(lap_of(CIRCLE, RIG, 3), 3, RIG, SETTINGS, "on")
SMAP = static_map(RIG.actuator, RIG.controller)


@pytest.fixture
def lessons(tmp_path: Path) -> Lessons:
    return Lessons(tmp_path / "learned")


def leg_of(order: Order) -> Leg:
    return first_leg(SMAP, order.lap, order.laps, REST)


def seen_of(order: Order, off: tuple[float, float]) -> Seen:
    """Of a run whose tip was `off` [m] in the first lap, and half of that later."""
    leg = leg_of(order)
    seen, index = Seen(leg), np.arange(leg.ticks)
    rows = np.zeros(leg.ticks, record_dtype(Telemetry))
    late = index >= len(leg.p)
    rows["p_meas"] = leg.at(index) - np.where(late[:, None], 0.5, 1.0) * np.array(off)
    seen.add(index[:1234], rows[:1234])
    seen.add(index[1234:], rows[1234:])
    return seen


def begun(lessons: Lessons, order: Order) -> Learned:
    found = with_learned(leg_of(order), order, lessons).learned
    assert found is not None
    return found


def test_what_a_repeat_taught_is_read_as_it_was_kept(lessons: Lessons) -> None:
    key, course = key_of(ONCE), untaught_course(2000, RIG)
    assert lessons.read(key) is None
    error = np.full((2000, 2), 1e-3)
    once = Course(taught(course.first, error, DT), course.later, (2e-3, None))
    lessons.keep(key, once)
    found = lessons.read(key)
    assert found is not None and found.errors == (2e-3, None)
    assert found.first.next == pytest.approx(once.first.next, abs=1e-8)
    assert found.first.rmse == once.first.rmse and math.isinf(found.later.rmse)
    assert (found.first.repeats, found.first.cutoff) == (1, once.first.cutoff)
    assert lessons.forget(key) and not lessons.forget(key) and lessons.read(key) is None


@pytest.mark.parametrize("content", [b"", b"no zip", None])
def test_a_file_that_cannot_be_read_counts_as_not_learned_and_is_written_anew(
    lessons: Lessons, content: bytes | None
) -> None:
    key, course = key_of(ONCE), untaught_course(2000, RIG)
    lessons.keep(key, course)
    (file,) = lessons.folder.iterdir()
    file.write_bytes(file.read_bytes()[:-100] if content is None else content)
    assert lessons.read(key) is None
    lessons.keep(key, course)
    assert lessons.read(key) is not None


def test_the_one_that_was_kept_longest_ago_makes_room(lessons: Lessons) -> None:
    course = untaught_course(10, RIG)
    for k in range(KEPT):
        lessons.keep(f"{k:024x}", course)
        os.utime(lessons.folder / f"{k:024x}.npz", (k, k))
    lessons.keep("f" * 24, course)
    assert lessons.read(f"{0:024x}") is None and lessons.read(f"{1:024x}") is not None
    assert len(list(lessons.folder.iterdir())) == KEPT


def test_another_path_arm_controller_or_gain_is_another_key() -> None:
    softer = RIG.model_copy(update={"actuator": PRESETS["P2"]})
    nearer = replace(ONCE.lap, p=ONCE.lap.p + 1e-9)
    others = [
        ONCE,
        ONCE._replace(lap=nearer),
        THRICE,
        ONCE._replace(rig=softer),
        ONCE._replace(settings=with_controller(Settings(), "preview", {"K_P": 0.4})),
        ONCE._replace(settings=with_controller(Settings(), "paper")),
        ONCE._replace(settings=SETTINGS.model_copy(update={"sensed": 32})),
    ]
    assert len({key_of(order) for order in others}) == len(others)
    assert key_of(ONCE) == key_of(ONCE._replace(learning="frozen", laps=7))


def test_a_repeat_teaches_the_next_and_a_usual_run_follows_the_best(lessons: Lessons) -> None:
    planned = with_learned(leg_of(ONCE), ONCE._replace(learning="off"), lessons)
    before = begun(lessons, ONCE)
    assert before == Learned(key=key_of(ONCE), learning=True, errors=())
    teach(lessons, ONCE, Repeat(before, seen_of(ONCE, (2e-3, 0.0)), 2e-3))
    usual = with_learned(leg_of(ONCE), ONCE._replace(learning="frozen"), lessons)
    assert usual.learned == Learned(key=key_of(ONCE), learning=False, errors=(2e-3,))
    assert usual.planned == pytest.approx(planned.planned), "the best is the first, the plan alone"
    repeat = with_learned(leg_of(ONCE), ONCE, lessons)
    assert repeat.planned is not None and planned.planned is not None
    assert np.abs(repeat.planned - planned.planned).max() > 1e-4
    anew = with_learned(leg_of(ONCE), ONCE._replace(learning="anew"), lessons)
    assert anew.learned == Learned(key=key_of(ONCE), learning=True, errors=())


def test_laps_are_learned_apart_from_the_first(lessons: Lessons) -> None:
    teach(lessons, THRICE, Repeat(begun(lessons, THRICE), seen_of(THRICE, (2e-3, 0.0)), 2e-3))
    course = lessons.read(key_of(THRICE))
    assert course is not None
    assert course.first.next[1000] == pytest.approx([1.4e-3, 0.0], abs=0.05e-3)
    assert course.later.next[1000] == pytest.approx([0.7e-3, 0.0], abs=0.05e-3)
    leg = leg_of(THRICE)
    c = corrections(leg, course, True, DT)
    n = len(course.first.next)
    assert not c[: leg.again - 250].any()
    assert c[leg.again : leg.again + n] == pytest.approx(course.first.next)
    assert c[leg.again + n : leg.again + 2 * n] == pytest.approx(course.later.next)
    assert not corrections(leg, course, False, DT).any(), "the best repeat is the first one, the plan alone"


def test_after_a_pause_the_correction_is_that_of_the_rows_that_are_left(lessons: Lessons) -> None:
    teach(lessons, THRICE, Repeat(begun(lessons, THRICE), seen_of(THRICE, (2e-3, 0.0)), 2e-3))
    course = lessons.read(key_of(THRICE))
    assert course is not None
    n = len(course.first.next)
    course = replace(course, first=replace(course.first, next=np.outer(np.arange(n), [1e-6, 0.0])))
    leg = next_leg(SMAP, THRICE.lap, 3, REST, Place(n - 300, REST))
    c = corrections(leg, course, True, DT)
    assert c[leg.again : leg.again + 300] == pytest.approx(course.first.next[-300:])
    assert c[leg.again + 300 : leg.again + 300 + n] == pytest.approx(course.later.next)


def test_a_repeat_that_is_broken_off_makes_the_next_more_careful(lessons: Lessons) -> None:
    teach(lessons, ONCE, Repeat(begun(lessons, ONCE), seen_of(ONCE, (2e-3, 0.0)), 2e-3))
    teach(lessons, ONCE, Repeat(begun(lessons, ONCE), None, None))
    course = lessons.read(key_of(ONCE))
    assert course is not None and course.errors == (2e-3, None)
    assert course.first.cutoff < untaught_course(1, RIG).first.cutoff


def test_what_was_forgotten_meanwhile_is_not_taught(lessons: Lessons) -> None:
    teach(lessons, ONCE, Repeat(begun(lessons, ONCE), seen_of(ONCE, (2e-3, 0.0)), 2e-3))
    before = begun(lessons, ONCE)
    lessons.forget(key_of(ONCE))
    teach(lessons, ONCE, Repeat(before, seen_of(ONCE, (1e-3, 0.0)), 1e-3))
    assert lessons.read(key_of(ONCE)) is None


def test_a_tip_that_was_hardly_seen_teaches_nothing(lessons: Lessons) -> None:
    seen = seen_of(ONCE, (2e-3, 0.0))
    seen.first[::3] = np.nan
    teach(lessons, ONCE, Repeat(begun(lessons, ONCE), seen, 2e-3))
    assert lessons.read(key_of(ONCE)) is None


def test_without_a_plan_nothing_is_learned(lessons: Lessons) -> None:
    order = ONCE._replace(settings=with_controller(Settings(), "letter"))
    assert with_learned(leg_of(order), order._replace(learning="frozen"), lessons).learned is None
    with pytest.raises(ParameterError, match="controller letter follows no planned torques"):
        with_learned(leg_of(order), order, lessons)
