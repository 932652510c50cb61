"""The cheapest assignment, against scipy's."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from controller.drivers.tracker import assigned


@pytest.mark.parametrize("seed", range(300))
def test_every_row_gets_a_column_of_its_own_at_the_least_cost(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 11))
    m = int(rng.integers(n, 40))
    cost = rng.uniform(0.0, 1.0, (n, m)) if seed % 3 else rng.integers(0, 4, (n, m)).astype(float)
    found = assigned(cost)
    assert len(set(found.tolist())) == n
    rows, columns = linear_sum_assignment(cost)
    assert cost[np.arange(n), found].sum() == pytest.approx(cost[rows, columns].sum(), abs=1e-12)


def test_nothing_is_assigned_to_nobody() -> None:
    assert assigned(np.zeros((0, 5))).shape == (0,)
