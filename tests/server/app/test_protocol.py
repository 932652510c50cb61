"""The protocol of docs/protocol.md, searched at random: loss, delay, duplication, two servers, restarts of the rig."""

import itertools
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from controller.schema.modes import Request
from tests.server.protocol import ANYTHING, FATES, World

pytestmark = pytest.mark.keyed()

ASKED = (Request.NONE, Request.ARM, Request.HOLD, Request.FOLLOW, Request.TRACK, Request.REST, Request.CLEAR)
SERVER, FATE = st.integers(0, 1), st.sampled_from(FATES)
ACT = st.one_of(
    st.tuples(st.just("ask"), SERVER, st.sampled_from(ASKED)),
    st.tuples(st.just("step"), SERVER, FATE),
    st.tuples(st.just("step"), SERVER, st.just("answered")),
    st.tuples(st.just("press"), SERVER, st.none() | FATE),
    st.tuples(st.just("press_within"), SERVER, st.none()),
    st.tuples(st.just("step_stop"), SERVER, FATE),
    st.tuples(st.just("see"), SERVER, st.none()),
    st.tuples(st.just("present"), SERVER, st.none()),
    st.tuples(st.just("run"), st.sampled_from([1, 100, 2100]), st.none()),
    st.tuples(st.just("late"), st.integers(0, 5), st.just(False)),
    st.tuples(st.just("late"), st.integers(0, 5), st.just(True)),
    st.tuples(st.just("restart"), st.none(), st.none()),
)
"""What may happen next."""
MOVED = [("ask", 0, Request.ARM), ("step", 0, "answered"), ("see", 0, None), ("present", 0, None)]
MOVED += [("ask", 0, Request.FOLLOW), ("step", 0, "answered"), ("see", 0, None)]
"""Most is worth looking at when the rig moves."""
Act = tuple[str, object, object]
ONE = [
    *[[("ask", 0, Request.NONE), ("step", 0, fate)] for fate in FATES],
    *[[("ask", 0, Request.FOLLOW), ("step", 0, fate)] for fate in FATES[1:]],
    [("ask", 0, Request.TRACK), ("step", 0, "reply lost")],
    [("ask", 0, Request.TRACK), ("step", 0, "stalled")],
    [*[("ask", 0, Request.NONE), ("step", 0, "answered")] * 2, ("late", 1, True)],
    [("ask", 0, Request.FOLLOW), ("ask", 0, Request.HOLD), ("step", 0, "answered")],
    [("ask", 0, Request.NONE), ("ask", 0, Request.FOLLOW), ("step", 0, "answered")],
    [("step", 0, "answered")],
    [("step", 0, "lost")],
    [("see", 0, None)],
    [("late", 0, False)],
    [("late", 1, True)],
]
"""One server, with the rig in FOLLOW: targets and presses whose replies or messages are lost, late or doubled."""
TWO = [
    [("press", 0, None), ("step_stop", 0, "answered")],
    [("press", 0, None), ("step_stop", 0, "reply lost")],
    [("press", 0, None), ("step_stop", 0, "lost"), ("ask", 0, Request.FOLLOW), ("step", 0, "answered")],
    [("press", 1, None), ("step_stop", 1, "answered")],
    [("press", 1, "answered"), ("step_stop", 1, "answered")],
    [("ask", 0, Request.NONE), ("ask", 0, Request.CLEAR), ("press", 1, None), ("step_stop", 1, "answered")],
    [("press", 0, "late"), ("step_stop", 0, "answered"), ("ask", 0, Request.CLEAR), ("step", 0, "answered")],
    [("step_stop", 0, "answered")],
    [("ask", 0, Request.HOLD), ("press", 0, None), ("step", 0, "answered")],
    [
        *[("ask", 0, Request.FOLLOW), ("step", 0, "reply lost"), ("see", 0, None)],
        *[("ask", 0, Request.CLEAR), ("press_within", 0, None), ("step", 0, "answered")],
    ],
    [("ask", 0, Request.HOLD), ("step", 0, "lost")],
    [("ask", 0, Request.CLEAR), ("step", 0, "late")],
    [("ask", 0, Request.CLEAR), ("step", 0, "answered")],
    [("see", 0, None)],
    [("run", 2100, None), ("see", 1, None), ("ask", 1, Request.CLEAR), ("step", 1, "answered")],
    [("late", 0, False)],
]
"""E-STOPs of two servers among requests that clear them."""
BOOTS = [
    [("restart", None, None)],
    [("restart", None, None), ("see", 0, None)],
    [("press", 0, None), ("restart", None, None), ("step_stop", 0, "answered")],
    [("press", 0, None), ("step_stop", 0, "lost"), ("restart", None, None), ("see", 0, None)],
    [("ask", 0, Request.ARM), ("restart", None, None), ("step", 0, "answered")],
    [("ask", 0, Request.ARM), ("restart", None, None), ("see", 0, None), ("step", 0, "answered")],
    [("ask", 0, Request.ARM), ("step", 0, "answered"), ("see", 0, None)],
    [("ask", 0, Request.FOLLOW), ("step", 0, "late")],
    [("present", 0, None), ("ask", 0, Request.FOLLOW), ("step", 0, "answered")],
    [("press", 0, None), ("step_stop", 0, "answered")],
    [("step_stop", 0, "answered")],
    [("late", 0, False)],
]
"""Restarts of the rig that the server has seen, or not yet, with something on its way."""
LONG = bool(os.environ.get("TENDRIL_LONG"))


def act(world: World, what: str, one: object, other: object) -> None:
    """Let it happen."""
    server = world.servers[one] if isinstance(one, int) and one < 2 else world.servers[0]
    if what == "ask":
        world.ask(server, Request(other))  # type: ignore[arg-type]
    elif what == "present":
        server.operator.present(ANYTHING)
    elif what == "press":
        world.press(server, other)  # type: ignore[arg-type]
    elif what == "late":
        world.deliver(one, bool(other))  # type: ignore[arg-type]
    elif what == "run":
        world.run(one)  # type: ignore[arg-type]
    elif what == "restart":
        world.restart()
    elif what == "see":
        server.see()
    elif what == "press_within":
        server.pressed_within = True
    else:
        getattr(server, what)(other)


def play(folder: Path, acts: list[Act]) -> World:
    """All of them; the judge in the world raises."""
    world = World(folder)
    try:
        for one in acts:
            act(world, *one)
    except BaseException:
        world.restore()
        raise
    world.close()
    return world


@settings(
    max_examples=2000 if LONG else 40, deadline=None, suppress_health_check=list(HealthCheck), derandomize=not LONG
)
@given(moved=st.booleans(), acts=st.lists(ACT, min_size=3, max_size=30))
def test_nothing_old_twice_or_untold_moves_the_rig(
    moved: bool, acts: list[Act], tmp_path_factory: pytest.TempPathFactory
) -> None:
    play(tmp_path_factory.mktemp("ring"), (MOVED if moved else []) + acts)


@pytest.mark.parametrize("first", range(len(ONE)))
def test_every_few_things_that_can_come_of_a_drag(first: int, tmp_path: Path) -> None:
    for acts in itertools.product(ONE, repeat=2 if LONG else 1):
        play(tmp_path, [*MOVED, *ONE[first], *itertools.chain(*acts)])


@pytest.mark.parametrize("first", range(len(TWO)))
def test_every_few_things_that_can_come_of_an_e_stop(first: int, tmp_path: Path) -> None:
    for acts in itertools.product(TWO, repeat=2 if LONG else 1):
        play(tmp_path, [*MOVED, *TWO[first], *itertools.chain(*acts)])


@pytest.mark.parametrize("first", range(len(BOOTS)))
def test_every_few_things_that_can_come_of_a_restart(first: int, tmp_path: Path) -> None:
    for acts in itertools.product(BOOTS, repeat=2 if LONG else 1):
        play(tmp_path, [*MOVED, *BOOTS[first], *itertools.chain(*acts)])
