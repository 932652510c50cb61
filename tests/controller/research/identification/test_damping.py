import math

import numpy as np
import pytest

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.motion.damping import find_peaks, log_decrement, noise_of
from controller.research.identification.motion.rayleigh import rayleigh, rayleigh_ratio
from tests.controller.coverage import RATES, decays

pytestmark = pytest.mark.keyed()

NOISE = 2e-4
OMEGA = 2 * math.pi * 2.5


def decay(zeta: float, seed: int, rest: float = 0.0, height: float = 0.05) -> tuple[Array, Array]:
    """The damped oscillator's own solution at 100 Hz, with noise."""
    t = np.arange(300) * 0.01
    free = height * np.exp(-zeta * OMEGA * t) * np.cos(OMEGA * math.sqrt(1 - zeta**2) * t - 0.3)
    return t, free + rest + np.random.default_rng(seed).normal(0.0, NOISE, t.size)


@pytest.mark.parametrize("zeta", [0.03, 0.07, 0.2, 0.35])
def test_the_decrement_recovers_the_damping_ratio_of_an_oscillator_within_2_percent(zeta: float) -> None:
    found = log_decrement([decay(zeta, seed) for seed in range(8)])
    assert found.zeta.value == pytest.approx(zeta, rel=0.02)
    assert found.omega_d.value == pytest.approx(OMEGA * math.sqrt(1 - zeta**2), rel=0.005)
    assert found.omega == pytest.approx(OMEGA, rel=0.005)


@pytest.mark.parametrize("rest", [5e-4, 5e-3])
def test_a_wrong_rest_does_not_bias_the_decrement(rest: float) -> None:
    found = log_decrement([decay(0.07, seed, rest) for seed in range(8)])
    assert found.zeta.value == pytest.approx(0.07, rel=0.01)


@pytest.mark.parametrize("rate", RATES[::2], ids=str)
@pytest.mark.parametrize(("count", "times", "least"), [(1, 100, 0.88), (3, 100, 0.88), (20, 10, 0.7)])
def test_19_of_20_confidence_intervals_hold_the_true_values(
    count: int, times: int, least: float, rate: tuple[float, float, float]
) -> None:
    """`python -m tests.controller.coverage` asks more often, of every number that has an interval."""
    for found in decays(count, rate, times):
        assert least <= found.held <= (0.99 if times == 100 else 1.0), found
        assert abs(found.bias) < 5e-3, found


def test_peaks_are_placed_within_a_hundredth_of_a_sample() -> None:
    t = np.arange(200) * 0.01
    peaks = find_peaks(t, np.cos(2 * math.pi * 1.5 * t - 0.7))
    exact = (0.7 + math.pi * np.arange(peaks.t.size)) / (2 * math.pi * 1.5)
    np.testing.assert_allclose(peaks.t, exact, atol=1e-4)
    np.testing.assert_allclose(np.abs(peaks.s), np.abs(peaks.s[0]), rtol=1e-3)
    np.testing.assert_array_equal(np.sign(peaks.s[1:]), -np.sign(peaks.s[:-1]))


def test_the_noise_is_found_below_a_moving_signal() -> None:
    assert noise_of(decay(0.07, 1)[1]) == pytest.approx(NOISE, rel=0.3)


def test_a_signal_without_swings_is_refused() -> None:
    t = np.arange(300) * 0.01
    with pytest.raises(DataError, match="0 peaks stand out of the noise"):
        log_decrement([(t, np.exp(-t))])


def test_rayleigh_damping_keeps_every_mode_of_a_chain_within_the_bounds_it_states() -> None:
    K = 900.0 * (2 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1))
    M = np.diag([1.0, 2.0, 1.0, 0.5, 1.0, 1.5])
    omegas = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    band = rayleigh(0.1, float(omegas.min()), float(omegas.max()))
    B = band.alpha * M + band.beta * K
    zero, one = np.zeros((6, 6)), np.eye(6)
    modes = np.linalg.eigvals(np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, B)]]))
    ratios = -modes.real / np.abs(modes)
    assert ratios.min() >= band.zeta_low - 1e-12 and ratios.max() == pytest.approx(band.zeta_high)
    first = ratios[np.argsort(np.abs(modes))[0]]
    assert first == pytest.approx(0.1)
    assert rayleigh_ratio(band.alpha, band.beta, float(omegas.min())) == pytest.approx(0.1)
