"""What the planner makes of telemetry for the commissioning: a mode of releases, slow valves, the loop of raw ones."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from controller.errors import ParameterError
from controller.schema.hardware import Valves
from controller.schema.modes import Cause, Law, Mode, Request
from controller.schema.parameters import ControllerParameters, RigParameters, TwinParameters
from server.hardware.commissioning import planning, pressure, sweep
from server.hardware.commissioning.jog import jog_torque
from server.hardware.commissioning.planning import PressureSteps, Release
from tests.controller.trial import Trial

pytestmark = pytest.mark.keyed()

CLEAN: dict[str, Any] = {"friction": 0.0, "hysteresis": 0.0, "creep": (0.0, 0.0)}


def blind(rig: RigParameters) -> Trial:
    """The twin in open loop, without sensors, as the steps have it."""
    trial = Trial(parameters=rig, law=Law.OPEN_LOOP, u_open=(0.0, 0.0), sensed=0)
    trial.arm()
    trial.ask(Request.FOLLOW, (0.2, 0.0), 400)
    return trial


def released(repeats: int = 2, **twin: Any) -> tuple[tuple[Release, ...], RigParameters]:
    """As the decay step does it, with the rig's own telemetry."""
    rig = RigParameters(twin=TwinParameters(**twin))
    trial, found = blind(rig), []
    rest = np.nanmean(trial.run(400)["p_meas"], axis=0)
    for u in planning.release_torques(rig, 0.7, repeats):
        rows = []
        for share in np.arange(0.0, 1.0, 0.0015 / max(map(abs, u)))[1:]:
            trial.switch(u_open=(share * u[0], share * u[1]))
            rows.append(trial.run(50))
            if np.linalg.norm(rows[-1]["p_meas"][-1] - rest) > sweep.TRAVEL * rig.actuator.length:
                break
        rows.append(trial.run(1200))
        trial.switch(u_open=(0.0, 0.0))
        slot = int(rows[-1]["slot"][-1])
        whole = np.concatenate([*rows, trial.run(2800)])
        kept = whole[np.random.default_rng(1).random(len(whole)) > 0.01]  # some slots are lost
        found.append(Release(*(kept[name].copy() for name in ("slot", "pressure_meas", "u_hat", "p_meas")), slot))
    return tuple(found), rig


@pytest.mark.parametrize(
    "twin, zeta, kappa, off",
    [
        ({"zeta": 0.1} | CLEAN, 0.1, 39.93, 0.05),
        ({"zeta": 0.1}, 0.1, 49.2, 0.3),
        ({"zeta": 0.1, "inflate_time": 0.08, "exhaust_time": 0.1}, 0.1, 49.2, 0.5),  # longer than a quarter of a swing
        ({"zeta": 0.05, "stiffness_scale": 1.8}, 0.05, 49.2, 0.6),
        ({}, 0.352, 49.2, 0.15),  # hardly swings
    ],
)
def test_releases_tell_the_damping_ratio_and_kappa_of_the_twin(
    twin: dict[str, Any], zeta: float, kappa: float, off: float
) -> None:
    """kappa of small motions, which creep and hysteresis stiffen; they and friction count as damping in part."""
    releases, rig = released(**twin)
    found = planning.swing(releases, rig)
    here = planning.kappa_of(found.frequency.value, rig)
    interval = f"{found.zeta.low:.3f} to {found.zeta.high:.3f}"
    print(f"{twin}: zeta {found.zeta.value:.3f} ({interval}), kappa {here:.1f} of {kappa}")
    assert 0.95 * zeta < found.zeta.value < (1.0 + off) * zeta
    assert here == pytest.approx(kappa, rel=0.05 if off < 0.1 else 0.3)
    assert found.misfit < 0.06 and found.friction < 5e-3


def test_two_releases_tell_no_interval_and_so_no_damping() -> None:
    releases, rig = released(1)
    with pytest.raises(ParameterError, match="2 releases: at least 4 are needed"):
        planning.swing(releases, rig)


def stepped(rig: RigParameters, level: float, hold: int, levels: Sequence[float] = pressure.LEVELS) -> Any:
    """Steps of all four chambers, or the cause for which the rig stopped."""
    trial, found = blind(rig), []
    for chamber in range(4):
        trial.run(400)
        rows, starts = [trial.run(400)], []
        for share in levels:
            starts.append(int(rows[-1]["slot"][-1]))
            trial.switch(u_open=jog_torque(chamber, share * level, rig))
            rows.append(trial.run(hold))
        whole = np.concatenate(rows)
        if (stopped := whole["mode"] == Mode.E_STOP).any():
            return Cause(int(whole["cause"][stopped][0]))
        asked, shown = whole["pressure_cmd"][:, chamber], whole["pressure_meas"][:, chamber]
        found.append(PressureSteps(whole["slot"].copy(), asked.copy(), shown.copy(), tuple(starts)))
    return tuple(found)


def test_chambers_too_slow_for_what_is_believed_are_found_by_small_steps_first() -> None:
    twin = TwinParameters(inflate_time=0.4, exhaust_time=0.4)
    rig = RigParameters(twin=twin)
    stopped = stepped(rig, 80e3, 800)
    assert stopped == Cause.PRESSURE_MISMATCH
    assert "Step by 25 kPa" in pressure.advice("pressure", stopped, Valves(driver="modbus"))
    small = pressure.judged(planning.pressure_fit(stepped(rig, 25e3, 3000), rig), 25e3)
    assert small.good, small.text
    believed = {name.split(".")[1]: value for name, value in small.changes.items() if name.startswith("controller")}
    wiser = RigParameters(twin=twin, controller=ControllerParameters(**believed))  # type: ignore[arg-type]
    found = pressure.judged(planning.pressure_fit(stepped(wiser, 80e3, 3000), wiser), 80e3)
    assert found.good, found.text
    assert found.changes["controller.pneumatic_lag"] == pytest.approx(0.43, abs=0.05)


def test_chambers_that_are_no_raw_valves_are_refused_by_their_number() -> None:
    rig = RigParameters()
    steps = stepped(rig, 27e3, 800, pressure.FIRST_LEVELS)
    still = steps[2]._replace(shown=np.zeros_like(steps[2].shown))
    valves = Valves(driver="serial", command="opening")
    with pytest.raises(ParameterError, match="chamber 3: its pressure moved by 0 Pa"):
        planning.raw_loop((*steps[:2], still, steps[3]), valves, rig)
