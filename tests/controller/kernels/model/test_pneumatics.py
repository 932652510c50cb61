"""From torques to chambers, and the air lines' delay."""

import numpy as np
import pytest

from controller.kernels.model.pneumatics import chamber_pressures, delay, first_order_lag

pytestmark = pytest.mark.keyed()


def test_one_chamber_of_a_pair_is_pressurised_by_the_sign_of_its_torque() -> None:
    p, slopes = np.full(4, np.nan), np.array([1e6, 2e6, 3e6, 4e6])
    chamber_pressures(np.array([0.03, -0.06]), slopes, p)
    assert p == pytest.approx([30e3, 0.0, 0.0, 240e3])
    chamber_pressures(np.array([-0.03, 0.06]), slopes, p)
    assert p == pytest.approx([0.0, 60e3, 180e3, 0.0])
    chamber_pressures(np.zeros(2), slopes, p)
    assert not np.signbit(p).any()


def test_the_lag_follows_the_exponential_whatever_the_step() -> None:
    p = 0.0
    for _ in range(50):
        p = first_order_lag(p, 1.0, 0.05, 1e-3)
    assert p == pytest.approx(1 - np.exp(-1))
    assert first_order_lag(0.0, 1.0, 0.05, 0.05) == pytest.approx(p)


@pytest.mark.parametrize("ticks", [0, 1, 50])
def test_a_torque_comes_out_of_the_line_after_its_dead_time(ticks: int) -> None:
    ring, head, out = np.zeros((ticks + 1, 2)), 0, []
    for n in range(ticks + 10):
        u1, u2, head = delay(n + 1.0, -1.0 - n, head, ring)
        assert u1 == -u2
        out.append(u1)
    assert out == [0.0] * ticks + [n + 1.0 for n in range(10)]
