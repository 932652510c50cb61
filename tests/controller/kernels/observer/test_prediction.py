"""The observer's tip is as good as its marker: little noise, no lag, on arms and cameras not told."""

import math
from typing import Any

import numpy as np
import pytest

from controller.arrays import Rows
from controller.drivers.twin import inject
from controller.kernels.observer.alpha_beta import ALPHA_MAX, ALPHA_MIN, CHANCE, alpha_of, beta_of
from controller.kernels.observer.prediction import NOISE_VARIANCE
from controller.schema.actuator import PRESETS
from controller.schema.fit import TWIN
from controller.schema.messages import TwinFaults
from controller.schema.modes import Law, Mode, Request
from controller.schema.parameters import (
    OBSERVER_GAIN_MAX,
    REPEATING,
    ControllerParameters,
    RigParameters,
    TwinParameters,
)
from controller.simulation.case import Case, Setup, run_case
from tests.controller.desk import MS
from tests.controller.trial import Trial, distance, true_tip

pytestmark = pytest.mark.keyed()

NOISE = 1e-4
"""Of the twin's markers [m], in each coordinate."""
TIP, ROD_6 = 1 << 9, 1 << 5


def followed(
    reference: str, name: str = "P1", predict: bool = True, kappa: float = TWIN["kappa"], sensed: int = TIP, **twin: Any
) -> Rows:
    """Rows of the run, without the approach."""
    controller = ControllerParameters(observer_kappa=kappa, predict=predict)
    gains = REPEATING.model_copy(update={"sensed": sensed})
    rows = run_case(Case(reference, name), Setup(TwinParameters(**twin), controller, gains)).rows
    return rows[len(rows) // 3 :]


def rms(rows: Rows) -> float:
    """Of the distance of the observer's tip from the true one [m]."""
    return float(np.sqrt(np.mean(distance(rows["p_hat"], true_tip(rows)) ** 2)))


@pytest.mark.parametrize("plant", ["rod", "cosserat"])
@pytest.mark.parametrize("name", PRESETS)
def test_at_rest_and_in_slow_motion_the_tip_is_no_noisier_than_its_marker(name: str, plant: str) -> None:
    trial = Trial(
        name,
        RigParameters(
            actuator=PRESETS[name],
            controller=ControllerParameters(observer_kappa=TWIN["kappa"]),
            twin=TwinParameters(plant=plant),
        ),
    )
    trial.arm()
    trial.follow(0.15, 0.1, 4.0)
    rest = trial.run(2000)
    off, marker = rest["p_hat"] - true_tip(rest), rest["p_meas"] - true_tip(rest)
    assert off.std(axis=0).max() < marker.std(axis=0).min()
    if plant == "rod":  # of the other one the model knows less, and leaves it at u / (L K_o)
        assert rms(rest) < math.sqrt(2.0) * NOISE
    assert rms(followed("vu", name, plant=plant)) < (1.0 if plant == "rod" else 2.5) * math.sqrt(2.0) * NOISE


@pytest.mark.parametrize(("reference", "name", "most"), [("circle_1hz", "P1", 0.4e-3), ("circle_2hz", "P3", 1.2e-3)])
def test_fast_motion_is_followed_without_lag(reference: str, name: str, most: float) -> None:
    """Two samples' speed carried it 0.6 and 2.4 mm off."""
    assert rms(followed(reference, name)) < most


@pytest.mark.parametrize("name", ["P1", "P2"])
@pytest.mark.parametrize("reference", ["vu", "circle_1hz"])
def test_by_rod_6_alone_it_is_no_worse_than_by_two_samples(reference: str, name: str) -> None:
    assert rms(followed(reference, name, sensed=ROD_6)) < 1.05 * rms(followed(reference, name, False, sensed=ROD_6))


OTHER = [
    {"stiffness_scale": 1.2},
    {"stiffness_scale": 0.85},
    {"kappa": 20.0},
    {"kappa": 80.0},
    {"zeta": 0.1},
    {"zeta": 0.6},
    {"dead_time": 0.07},
    {"marker_noise": 1e-3},
    {"marker_noise": 2e-5},
    {"marker_latency": 0.009},
    {"marker_period": 0.002, "marker_latency": 0.001},
    {"marker_period": 0.03, "marker_latency": 0.02},
    {"plant": "cosserat"},
]


@pytest.mark.parametrize("twin", OTHER, ids=str)
@pytest.mark.parametrize("reference", ["vu", "circle_1hz"])
def test_on_other_arms_and_cameras_it_is_better_than_two_samples(reference: str, twin: dict[str, Any]) -> None:
    assert rms(followed(reference, **twin)) < rms(followed(reference, predict=False, **twin))


@pytest.mark.parametrize("noise", [2e-5, 1e-4, 1e-3])
def test_the_noise_of_a_marker_is_learnt_whatever_the_arm_does(noise: float) -> None:
    trial = Trial("P1", RigParameters(twin=TwinParameters(marker_noise=noise)))
    trial.arm()
    for target in ((0.12, 0.12), (0.12, -0.12), (0.2, 0.05)):
        trial.follow(*target, 2.0)
    learnt = np.sqrt(trial.rig.observer.prediction.noise)
    assert learnt == pytest.approx(noise, rel=0.25)


def test_the_filter_has_the_gains_of_its_steady_state() -> None:
    """An alpha-beta filter of these gains on white noise brings innovations of the variance that alpha was taken from.

    They hold where noise alone makes them (Kalata 1984: S = sigma^2 / (1 - alpha)).
    """
    assert alpha_of(1.0, 1.0) == ALPHA_MIN and alpha_of(1e6, 1.0) == ALPHA_MAX
    rng, T = np.random.default_rng(0), 0.01
    for alpha in (0.2, 0.4, 0.7):
        beta, variance = beta_of(alpha), CHANCE / (1.0 - alpha)
        assert alpha_of(variance, 1.0) == pytest.approx(alpha)
        # Kalata's process noise for these gains: white accelerations of the tracking index beta / (1 - alpha)^(1/2).
        index = beta / math.sqrt(1.0 - alpha)
        n = 200_000
        a = index / T**2 * rng.standard_normal(n)
        v = np.cumsum(a) * T
        x = np.cumsum(np.concatenate([[0.0], v[:-1]])) * T + np.cumsum(a) * 0.5 * T**2
        z, at, rate, innovations = x + rng.standard_normal(n), 0.0, 0.0, np.zeros(n)
        for k in range(n):
            at += T * rate
            innovations[k] = z[k] - at
            at += alpha * innovations[k]
            rate += beta / T * innovations[k]
        assert innovations[1000:].var() == pytest.approx(1.0 / (1.0 - alpha), rel=0.03)


def test_no_delay_of_the_samples_makes_it_swing() -> None:
    """Samples enter at their own time: the latest that are still used, at the strongest springs."""
    late = {"marker_period": 0.02, "marker_latency": 0.028}
    parameters = RigParameters(controller=ControllerParameters(observer_kappa=100.0), twin=TwinParameters(**late))
    trial = Trial("P1", parameters, K_o=(OBSERVER_GAIN_MAX,) * 2, B_o=(0.0, 0.0), law=Law.FF)
    trial.arm()
    trial.follow(0.15, 0.12, 4.0)
    rest = trial.run(2000)
    assert rms(rest) < 2e-4 and np.ptp(rest["p_hat"] - true_tip(rest), axis=0).max() < 5e-4


def test_a_chamber_that_suddenly_gives_less_than_the_model_knows_is_followed() -> None:
    off = []
    for predict in (True, False):
        controller = ControllerParameters(observer_kappa=TWIN["kappa"], predict=predict)
        trial = Trial("P1", RigParameters(controller=controller), law=Law.FF)
        trial.arm()
        trial.follow(0.2, 0.05, 3.0)
        trial.twin.chambers.torque_per_pascal[:] *= 0.7
        pushed = trial.run(1500)
        assert distance(true_tip(pushed)[-1], true_tip(pushed)[0]) > 0.01
        off.append((rms(pushed), rms(pushed[-300:])))
    assert off[0][0] < 1.1 * off[1][0] and off[0][1] < 5e-4


def test_out_of_sight_and_back_it_begins_where_it_is_seen() -> None:
    trial = Trial("P1", law=Law.FF)
    trial.arm()
    trial.follow(0.2, 0.05, 2.0)
    seen = trial.rig.observer.prediction.taken_ns.copy()
    inject(TwinFaults(sample_loss=1.0), trial.twin.faults)
    trial.run(400)
    inject(TwinFaults(), trial.twin.faults)
    back = trial.run(200)
    assert (trial.rig.observer.prediction.taken_ns > seen + 400 * MS).all()
    assert rms(back[-50:]) < 5e-4


def test_it_is_driven_by_the_pressures_that_are_measured_while_they_follow() -> None:
    trial = Trial("P1", law=Law.OPEN_LOOP, u_open=(0.03, 0.0))
    trial.arm()
    trial.ask(Request.FOLLOW, ticks=1500)
    observer, pascal = trial.rig.observer, trial.rig.control.pascal_per_torque[::2]
    p = trial.measurement["pressures"][0]
    assert observer.torque == pytest.approx((p[::2] - p[1::2]) / pascal, abs=1e-4)
    trial.rig.control.state["pressure_off"] = 10.0
    assert trial.run(1)["mode"][0] == Mode.E_STOP
    assert observer.torque == pytest.approx(observer.u_hat)


def test_at_the_least_noise_it_does_not_divide_by_nothing() -> None:
    trial = Trial("P1", RigParameters(twin=TwinParameters(marker_noise=0.0)))
    trial.arm()
    rows = trial.follow(0.15, 0.1, 2.0)
    assert np.isfinite(rows["p_hat"]).all() and trial.rig.observer.prediction.noise.min() >= NOISE_VARIANCE[0]
