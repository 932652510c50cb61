"""Gains that make the arm whip, within the page's bounds: it is in REST within a second, and the reason is named.

`python -m tests.controller.measure_gains` tries all corners, and that nothing else is stopped.
"""

import numpy as np
import pytest

from controller.assembly.controllers.registry import index_of
from controller.schema.messages import TwinFaults
from controller.schema.modes import Mode, Request
from controller.schema.parameters import SafetyLimits
from tests.controller.calm import Drag, drag
from tests.controller.trial import Trial
from tests.controller.whips import FREE, NAMED, RUNS, Gains, broken, judged, onset

pytestmark = pytest.mark.keyed()

LETTER = (("controller", index_of("letter")),)
"""The paper's own integral: with a kept one these two are stopped after 1.6 s."""
EVERYWHERE = (Gains("P1", 0.3, 20.0), Gains("P2", 5.0, 2.0), Gains("P1", 1.0, 15.0))
HARD = [
    *((mode, gains) for mode in RUNS for gains in EVERYWHERE),
    ("HOLD", Gains("P3", 5.0, 0.0, seed=1)),
    ("FOLLOW", Gains("P3", 0.3, 20.0)),
    ("TRACK", Gains("P3", 0.3, 20.0, others=LETTER)),
    # by little more than the reference moves
    ("FOLLOW", Gains("P1", 0.3, 14.0)),
    ("FOLLOW", Gains("P2", 4.0, 2.0, seed=2)),
    ("TRACK", Gains("P3", 0.3, 20.0, seed=10, others=(("K_o", (500.0, 500.0)), *LETTER))),
]


@pytest.mark.parametrize(("mode", "gains"), HARD, ids=str)
def test_a_whipping_arm_is_in_rest_within_a_second_and_the_reason_is_named(mode: str, gains: Gains) -> None:
    one = judged(RUNS[mode], gains)
    assert one.onset is not None, "these gains do not make it whip: try harder ones"
    assert one.reaction is not None and one.reaction <= one.onset + 1000
    assert one.mode == Mode.REST and one.cause in NAMED


def test_a_whip_is_named_though_markers_are_often_not_seen() -> None:
    """A drag of P2 under gains that make it whip, with 30 % of the markers lost."""
    how = Drag("walk", "P2", 3, TwinFaults(marker_loss=0.3), (("K_P", (5.0, 5.0)),))
    rows, begins = drag(how, SafetyLimits()), onset(drag(how, FREE))
    ends = broken(rows)
    assert begins is not None and ends is not None and ends <= begins + 1000
    assert rows["cause"][ends] in NAMED


@pytest.mark.parametrize("mode", RUNS)
def test_gains_half_as_hard_again_as_the_first_ones_are_not_stopped(mode: str) -> None:
    for actuator in ("P1", "P2", "P3"):
        assert broken(RUNS[mode](Gains(actuator, 0.45, 3.0), SafetyLimits())) is None


@pytest.mark.parametrize("actuator", ["P1", "P2", "P3"])
@pytest.mark.parametrize("kind", ["random", "walk", "sine 2", "square 2"])
def test_what_a_drag_commands_is_no_oscillation(actuator: str, kind: str) -> None:
    assert broken(drag(Drag(kind, actuator, seed=0), SafetyLimits())) is None


@pytest.mark.parametrize("actuator", ["P1", "P2", "P3"])
@pytest.mark.parametrize("fallen", [1, 60, 150, 300])
def test_an_arm_that_still_falls_when_it_is_armed_does_not_oscillate(actuator: str, fallen: int) -> None:
    """As quick as an operator, or a script, can be after an E-STOP: `fallen` ms later."""
    trial = Trial(actuator)
    trial.arm()
    trial.follow(0.03, 0.17, 2.0)
    trial.ask(Request.E_STOP, ticks=fallen)
    trial.ask(Request.CLEAR)
    rows = [trial.ask(Request.ARM, ticks=120), trial.follow(0.05, 0.14, 2.0)]
    assert broken(np.concatenate(rows)) is None
