"""The first mode from small steps: a second-order system of known truth, the twin, and the Cosserat plant."""

from typing import Any

import numpy as np
import pytest
from scipy.signal import lsim, lti

from controller.arrays import Array
from controller.assembly.stability import natural_modes
from controller.assembly.twin import twin_model
from controller.errors import ParameterError
from controller.schema.actuator import PRESETS
from controller.schema.modes import Law, Request
from controller.schema.parameters import RigParameters, TwinParameters
from controller.simulation.first_mode import (
    FirstMode,
    ModeModel,
    StepRecord,
    driving_torque,
    first_mode,
    mode_model,
    mode_response,
    step_torque,
)
from tests.controller.trial import Trial

DT, DWELL = 1e-3, 1500
STRAIGHT = ModeModel(10.0, np.array([[0.0, 0.0], [10.0, 5.0]]))
"""Of which a torque of both pairs moves the tip along y."""
CLEAN: dict[str, Any] = {"friction": 0.0, "hysteresis": 0.0, "creep": (0.0, 0.0)}


def lagged(steps: int, lag: float) -> Array:
    """Torques (n,2) [N m] that go to and fro with a first-order lag [s]."""
    square = np.concatenate([np.full(DWELL, u) for _ in range(steps) for u in (3e-3, -3e-3)])
    _, out, _ = lsim(lti([1.0], [lag, 1.0]), square, DT * np.arange(square.size), X0=[-3e-3 * lag])
    return np.column_stack([out, out])


def known(
    zeta: float,
    frequency: float,
    noise: float = 1e-4,
    lag: float = 0.05,
    step: float = 1.0,
    repeats: int = 3,
    seed: int = 1,
) -> StepRecord:
    """Of a system whose truth is known, sampled each 10 ms, 8 ms old, with an even drift."""
    torque = step * lagged(repeats, lag)
    omega, t = 2.0 * np.pi * frequency, DT * np.arange(len(torque))
    q = torque @ STRAIGHT.S[1]
    mode = lti([omega**2], [1.0, 2.0 * zeta * omega, omega**2])
    y = lsim(mode, q - q[0], t)[1] + q[0] + 5e-4 * t
    held = np.roll(np.repeat(y[::10], 10)[: len(y)], 8)
    tip = np.column_stack([np.full(len(t), 0.25), held])
    tip[:, 1] += np.repeat(np.random.default_rng(seed).normal(0.0, noise, len(t) // 10), 10)
    return StepRecord(DT, torque, tip, tuple(DWELL * i for i in range(2 * repeats)))


def swung(**twin: Any) -> FirstMode:
    """What is found of P1's twin with these numbers, from the rig's own telemetry."""
    parameters = RigParameters(twin=TwinParameters(**twin))
    u = step_torque(0.1, parameters)
    trial = Trial(parameters=parameters, law=Law.OPEN_LOOP, u_open=(-u, -u))
    trial.arm()
    trial.ask(Request.FOLLOW, (0.2, 0.0), DWELL)
    found = []
    for torque in (u, -u) * 3:
        trial.switch(u_open=(torque, torque))
        found.append(trial.run(DWELL))
    rows = np.concatenate(found)
    torques, measured = driving_torque(rows["pressure_meas"], rows["u_hat"], parameters)
    assert measured
    return first_mode(
        StepRecord(DT, torques, rows["p_meas"], tuple(DWELL * i for i in range(6))), mode_model(parameters)
    )


@pytest.mark.parametrize(
    ("zeta", "frequency", "lag"), [(0.05, 1.0, 0.05), (0.2, 3.0, 0.02), (0.35, 2.3, 0.1), (0.6, 5.0, 0.05)]
)
def test_frequency_and_damping_of_a_known_system_come_back_whatever_the_lag_of_its_input(
    zeta: float, frequency: float, lag: float
) -> None:
    found = first_mode(known(zeta, frequency, lag=lag), STRAIGHT)
    assert found.frequency.value == pytest.approx(frequency, rel=0.03)
    assert found.zeta.value == pytest.approx(zeta, rel=0.05)
    assert found.kappa.value == pytest.approx((2.0 * np.pi * frequency / STRAIGHT.omega) ** 2, rel=0.06)
    assert found.friction < 5e-4 and found.misfit < 0.03


def test_the_interval_holds_the_value_and_widens_with_noise() -> None:
    quiet, loud = (first_mode(known(0.2, 3.0, noise), STRAIGHT).zeta for noise in (5e-5, 2e-3))
    for found in (quiet, loud):
        assert found.low <= found.value <= found.high
    assert loud.high - loud.low > 3.0 * (quiet.high - quiet.low)


def test_without_friction_the_mode_is_that_of_the_differential_equation() -> None:
    q = lagged(1, 0.05)[:, 0]
    omega, zeta = 20.0, 0.2
    exact = lsim(lti([omega**2], [1.0, 2.0 * zeta * omega, omega**2]), q - q[0], DT * np.arange(q.size))[1]
    assert np.abs(mode_response(q - q[0], omega, zeta, 0.0, DT) - exact).max() < 0.03 * np.abs(exact).max()


def test_dry_friction_holds_the_mode_off_its_rest_by_as_much_as_it_can() -> None:
    q = np.concatenate([np.zeros(1), np.full(6000, 0.05)])
    left = 0.05 - mode_response(q, 20.0, 0.1, 3e-3, DT)[-1]
    assert 0.0 < abs(left) <= 3e-3


@pytest.mark.parametrize(("zeta", "kappa"), [(0.1, 17.4), (0.2, 39.93), (0.35, 25.0)])
def test_zeta_and_kappa_of_a_twin_without_friction_come_back(zeta: float, kappa: float) -> None:
    found = swung(zeta=zeta, kappa=kappa, **CLEAN)
    assert found.zeta.value == pytest.approx(zeta, rel=0.05)
    assert found.kappa.value == pytest.approx(kappa, rel=0.05)


@pytest.mark.parametrize("zeta", [0.1, 0.2, 0.352])
def test_friction_is_told_apart_from_damping_and_what_stiffens_small_motions_counts_as_kappa(zeta: float) -> None:
    found = swung(zeta=zeta)
    assert found.zeta.value == pytest.approx(zeta, rel=0.25)
    twin = TwinParameters()
    stiffer = twin.kappa * (1.0 + twin.hysteresis + sum(twin.creep))
    assert stiffer == pytest.approx(found.kappa.value, rel=0.15)
    assert found.friction > 5e-4


def test_a_plant_of_other_mathematics_has_its_own_first_mode() -> None:
    found = swung(plant="cosserat", zeta=0.1, friction=0.0)
    assert found.zeta.value == pytest.approx(0.1, rel=0.1)
    assert found.frequency.value == pytest.approx(3.4, rel=0.05)


def test_kappa_gives_the_chain_of_the_stability_command_the_frequency_that_was_measured() -> None:
    actuator, kappa = PRESETS["P2"], 23.0
    model = twin_model(actuator, TwinParameters(kappa=kappa))
    loose = model._replace(b=np.zeros_like(model.b), alpha=0.0)
    omega = float(np.abs(natural_modes(loose, model.rest)).min())
    assert (omega / mode_model(RigParameters(actuator=actuator)).omega) ** 2 == pytest.approx(kappa, rel=1e-6)


def test_what_tells_no_first_mode_is_refused_with_the_reason() -> None:
    still = known(0.2, 3.0)
    with pytest.raises(ParameterError, match=r"the tip moved by .* mm, less than 10 mm: too little"):
        first_mode(known(0.2, 3.0, step=0.01), STRAIGHT)
    with pytest.raises(ParameterError, match="does not swing: its damping ratio"):
        first_mode(known(1.6, 3.0), STRAIGHT)
    wild = still.tip + np.random.default_rng(0).normal(0.0, 0.05, still.tip.shape)
    with pytest.raises(ParameterError, match="does not move as one damped mode"):
        first_mode(still._replace(tip=wild), STRAIGHT)
    with pytest.raises(ParameterError, match="the tip was not seen"):
        first_mode(still._replace(tip=np.full_like(still.tip, np.nan)), STRAIGHT)
    with pytest.raises(ParameterError, match=r"travel = 5 m is more than .*, which half of u_max makes"):
        step_torque(5.0, RigParameters())


def test_pressures_that_nobody_measures_are_replaced_by_what_was_sent() -> None:
    parameters, sent = RigParameters(), lagged(1, 0.05)
    for pressure in (np.zeros((len(sent), 4)), np.full((len(sent), 4), np.nan)):
        torque, measured = driving_torque(pressure, sent, parameters)
        assert not measured and torque is sent
