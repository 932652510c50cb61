"""Times of devices on our clock, whatever their clocks do."""

import numpy as np
import pytest

from controller.drivers.clocks import OneWayClock, TwoWayClock

S, MS = 1_000_000_000, 1_000_000


@pytest.mark.parametrize("drift", [-1e-4, 0.0, 1e-4])
def test_times_of_capture_are_found_within_the_jitter_of_the_quickest_messages(drift: float) -> None:
    rng, clock = np.random.default_rng(1), OneWayClock()
    worst = 0
    for i in range(20_000):
        captured = 5_000 * S + i * 10 * MS
        device = int((captured - 1234 * S) * (1 + drift))
        found = clock.heard(device, captured + 2 * MS + int(rng.exponential(3 * MS)))
        if i > 200:
            worst = max(worst, abs(found - captured - 2 * MS))
    assert worst < 6.5 * MS, "the window of 30 s times 200 ppm, allowed to drift"


def test_no_time_of_capture_is_later_than_its_arrival() -> None:
    rng, clock = np.random.default_rng(2), OneWayClock()
    for i in range(5000):
        arrived = 100 * S + i * MS + int(rng.integers(0, 5 * MS))
        assert clock.heard(i * MS, arrived) <= arrived


@pytest.mark.parametrize("jump", [-3600 * S, 3600 * S])
def test_a_device_whose_clock_was_set_is_followed_at_once(jump: int) -> None:
    clock = OneWayClock()
    for i in range(500):
        clock.heard(7000 * S + i * 10 * MS, 10 * S + i * 10 * MS)
    assert abs(clock.heard(7000 * S + 5 * S + jump, 15 * S + 3 * MS) - 15 * S) <= 3 * MS


@pytest.mark.parametrize("drift", [-1e-4, 1e-4])
def test_questions_and_answers_find_the_offset_within_a_millisecond(drift: float) -> None:
    rng, clock = np.random.default_rng(3), TwoWayClock()
    assert not clock.known
    for i in range(2000):
        asked = 50 * S + i * 100 * MS
        there, back = (int(200_000 + rng.exponential(2 * MS)) for _ in range(2))
        device = int((asked + there) * (1 + drift)) + 900 * S
        clock.answered(asked, device, asked + there + back)
        if i > 100:
            assert abs(clock.ours(int((asked + there) * (1 + drift)) + 900 * S) - asked - there) < 4 * MS
    assert clock.known


def test_a_better_answer_moves_the_offset_slowly_and_all_the_way() -> None:
    clock = TwoWayClock()
    for i in range(100):
        clock.answered(i * 50 * MS, i * 50 * MS + 9 * MS, i * 50 * MS + 10 * MS)
    slow = clock.offset_ns
    offsets = []
    for i in range(100, 400):
        clock.answered(i * 50 * MS, i * 50 * MS + MS // 2, i * 50 * MS + MS)
        offsets.append(clock.offset_ns)
    assert slow == -4 * MS and offsets[-1] == 0
    assert max(np.diff([slow, *offsets])) <= 50_000, "a thousandth of the time between"
