"""What the signs step makes of the ways of the tip: signs, drift, and causes that the ways leave alone."""

import math

import numpy as np
import pytest

from server.hardware.commissioning.signs import Push, judged_signs

WAYS = (3.3e-6, 1.3e-6)
"""Of the model's pairs [m/Pa]."""


def pushes(u1: float, u2: float, drift: float = 1e-4, **more: float) -> list[Push]:
    """u1+ and u2+ move the tip along y by these ways [m], at the model's pressures."""
    found = []
    for chamber, dy, way in (("u1+", u1, WAYS[0]), ("u2+", u2, WAYS[1])):
        asked = more.get("asked", max(abs(dy), 0.01) / way)
        before, after = np.array([0.25, 0.01]), np.array([0.25, 0.01 + dy])
        found.append(Push(chamber, before, after, asked, more.get("rise", asked), drift))  # type: ignore[arg-type]
    return found


def test_both_pairs_to_plus_y_are_right() -> None:
    found = judged_signs(pushes(0.015, 0.012), WAYS)
    assert found.good and found.text == "tip along y: u1+ +15.0 mm, u2+ +12.0 mm"


@pytest.mark.parametrize("u1, u2", [(0.015, -0.015), (-0.015, 0.015)])
def test_of_one_pair_that_is_exchanged_the_ways_do_not_tell_which(u1: float, u2: float) -> None:
    """Where it is u1's, the frame that u1+ told is mirrored with them, and u2+ seems wrong."""
    found = judged_signs(pushes(u1, u2), WAYS)
    assert not found.good and "two chambers are exchanged, and these ways do not tell which" in found.text
    assert "u2-" not in found.text and "mirrored" not in found.text


def test_both_to_minus_y_is_a_mirrored_frame_or_both_pairs() -> None:
    found = judged_signs(pushes(-0.015, -0.015), WAYS)
    assert not found.good and "y of the frame is mirrored, or two chambers of each pair are exchanged" in found.text


def test_chambers_of_two_pairs_are_told_by_how_far_they_move_the_tip() -> None:
    exchanged = pushes(0.015, 0.015)
    exchanged = [one._replace(asked=0.015 / way) for one, way in zip(exchanged, reversed(WAYS), strict=True)]
    found = judged_signs(exchanged, WAYS)
    assert not found.good and "u1+ moves it by 1.3 mm/kPa and u2+ by 3.3" in found.text
    assert "u1+ and u2+ are exchanged, or this is another actuator" in found.text
    assert judged_signs(exchanged, (2e-6, 1.9e-6)).good, "where the model's pairs are alike, nothing is told by that"


@pytest.mark.parametrize("dy", [0.006, -0.006])
def test_a_way_near_the_drift_tells_no_sign_and_brings_no_advice(dy: float) -> None:
    found = judged_signs(pushes(0.015, dy, drift=2.5e-3), WAYS)
    assert not found.good and found.text.endswith(": u2+ tells no sign, the tip drifts by 2.5 mm in as long")
    assert "exchanged" not in found.text and "mirrored" not in found.text
    assert judged_signs(pushes(0.015, 0.006, drift=1e-3), WAYS).good


def test_a_chamber_that_hardly_moves_the_tip_is_said_with_what_its_sensor_showed() -> None:
    full = judged_signs(pushes(0.015, 0.001), WAYS)
    assert not full.good and "u2+ moves the tip by less than 3 mm along y, its sensor rose by 7.7 kPa" in full.text
    assert "did not fill" not in full.text
    empty = judged_signs(pushes(0.015, 0.001, asked=40e3, rise=300.0), WAYS)
    assert "its sensor rose by 0.3 kPa of 40.0: it did not fill" in empty.text
    assert "did not fill" not in judged_signs(pushes(0.015, 0.001, rise=math.nan), WAYS).text
