"""The common scene of a body that stands still: noise is no move, and everything that is seen is one."""

import numpy as np
import pytest

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode
from server.scene.body import TOLERANCES_M, moved

ROWS = record_dtype(Telemetry)


@pytest.mark.parametrize("name", TOLERANCES_M)
def test_a_row_looks_other_once_a_part_moved_further_than_its_tolerance(name: str) -> None:
    shown, row = np.zeros(1, ROWS)[0], np.zeros(1, ROWS)
    row[name] = 0.9 * TOLERANCES_M[name]
    assert not moved(row[0], shown)
    row[name].flat[-1] = -1.1 * TOLERANCES_M[name]
    assert moved(row[0], shown)


@pytest.mark.parametrize("name", TOLERANCES_M)
def test_a_part_that_is_lost_or_found_again_is_shown_at_once(name: str) -> None:
    row, lost = np.zeros(1, ROWS), np.zeros(1, ROWS)
    lost[name].flat[-1] = np.nan
    assert moved(lost[0], row[0])
    assert moved(row[0], lost[0])
    assert not moved(lost[0], lost[0])


def test_a_mode_and_the_markers_that_are_used_are_seen() -> None:
    shown, row = np.zeros(1, ROWS)[0], np.zeros(1, ROWS)
    row["tick"], row["mode"] = 1, Mode.E_STOP
    assert moved(row[0], shown)
    row["mode"], row["sensed"] = shown["mode"], 1
    assert moved(row[0], shown)


@pytest.mark.parametrize("mode", [Mode.FOLLOW, Mode.TRACK])
def test_every_new_row_is_shown_while_the_actuator_is_led(mode: Mode) -> None:
    shown, row = np.zeros(1, ROWS), np.zeros(1, ROWS)
    shown["mode"] = row["mode"] = mode
    assert not moved(row[0], shown[0])
    row["tick"] = 1
    assert moved(row[0], shown[0])
