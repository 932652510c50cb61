"""Spool valves, chambers and their pressure loops: against ISO 6358, the ideal gas and the paper's lag."""

import math

import numpy as np
import pytest

from controller.assembly.plant_parts import chambers, tuned_valve
from controller.kernels.plant.valve import ATMOSPHERE, Chambers, Valve, fill_chambers, valve_flow
from controller.schema.parameters import RigParameters, TwinParameters
from tests.controller.chains import compiled

DT = 1e-3
GAS, TEMPERATURE, REFERENCE_DENSITY = 287.0, 293.15, 1.1886
"""Air: gas constant [J/(kg K)], temperature [K] and density at 100 kPa [kg/m^3]."""


@compiled
def walk(chambers: Chambers, setpoints: np.ndarray, pressures: np.ndarray, flows: np.ndarray) -> None:
    """One tick for each row of `setpoints` (n,4) [Pa]: pressures after it [Pa] and the flows that made them [m^3/s]."""
    before = np.zeros(4)
    for i in range(setpoints.shape[0]):
        before[:] = chambers.pressure
        fill_chambers(i, setpoints[i], 1e-3, chambers)
        pressures[i] = chambers.pressure
        for j in range(4):
            flows[i, j] = valve_flow(chambers.valve, chambers.spool[j] + chambers.valve.offset, before[j])


def run(twin: TwinParameters, setpoints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pressures and flows (n,4) of chambers whose four setpoints are `setpoints` (n,) or its columns (n,4)."""
    columns = np.ascontiguousarray(np.broadcast_to(setpoints.reshape(len(setpoints), -1), (len(setpoints), 4)))
    pressures, flows = np.empty_like(columns), np.empty_like(columns)
    walk(chambers(RigParameters(twin=twin), twin.torque_gain), columns, pressures, flows)
    return pressures, flows


def stepped(start: float, end: float, **changes: float) -> np.ndarray:
    """Pressure (1000,) of a chamber without dead time after its setpoint, held for 8 s, steps from `start` to `end`."""
    twin = TwinParameters(**{"dead_time": 0.0, **changes})  # type: ignore[arg-type]
    return run(twin, np.repeat([start, end], [8000, 1000]))[0][8000:, 0]


def time_constant(p: np.ndarray, start: float, end: float) -> float:
    """When `p` has made 63.2 % of its way, between samples [s]."""
    share = np.append(0.0, (p - start) / (end - start))
    after = int(np.argmax(share >= 1 - math.exp(-1)))
    return DT * float(np.interp(1 - math.exp(-1), share[after - 1 : after + 1], [after - 1, after]))


def valve(**changes: float) -> Valve:
    return tuned_valve(TwinParameters(**changes), DT)  # type: ignore[arg-type]


def test_an_open_valve_passes_its_nominal_flow() -> None:
    """The data sheet's 100 l/min: from 6 bar to 5 bar, both gauge."""
    assert valve_flow(valve(), 1.0, 500e3) == pytest.approx(0.1 / 60, rel=0.02)


def test_flow_is_choked_below_the_critical_ratio_and_elliptic_above() -> None:
    v = valve()
    up = v.supply + ATMOSPHERE
    for ratio in (0.16, 0.25, 0.3 - 1e-9):
        assert valve_flow(v, 1.0, ratio * up - ATMOSPHERE) == v.conductance * up
    for ratio in (0.3 + 1e-9, 0.4, 0.65, 0.999, 1.0):
        ellipse = math.sqrt(1 - ((ratio - 0.3) / 0.7) ** 2)
        assert valve_flow(v, 0.5, ratio * up - ATMOSPHERE) == pytest.approx(
            0.5 * v.conductance * up * ellipse, abs=1e-12
        )


def test_flow_out_is_driven_by_the_chamber_and_in_by_the_supply() -> None:
    v = valve()
    choked = ATMOSPHERE / 0.3 + 10e3
    assert valve_flow(v, -1.0, choked - ATMOSPHERE) == pytest.approx(-v.conductance * choked, rel=1e-12)
    falling = [valve_flow(v, -1.0, p) for p in (240e3, 120e3, 60e3, 30e3, 1e3, 0.0)]
    assert np.all(np.diff(falling) > 0) and falling[-1] == 0.0
    assert valve_flow(v, 1.0, v.supply) == 0.0 == valve_flow(v, 0.0, 60e3)
    assert valve_flow(v, 1.0, 60e3) > 4 * -valve_flow(v, -1.0, 60e3)


def test_flow_near_the_ideal_nozzle_is_that_of_saint_venant() -> None:
    """Isentropic discharge of air; the ellipse at b = 0.528 stays within 2 % of it."""
    v, gamma = valve(critical_ratio=0.528), 1.4
    up = v.supply + ATMOSPHERE
    most = math.sqrt(gamma * (2 / (gamma + 1)) ** ((gamma + 1) / (gamma - 1)))
    for ratio in (0.55, 0.7, 0.85, 0.95):
        speed = math.sqrt(2 * gamma / (gamma - 1) * (ratio ** (2 / gamma) - ratio ** ((gamma + 1) / gamma)))
        share = valve_flow(v, 1.0, ratio * up - ATMOSPHERE) / (v.conductance * up)
        assert share == pytest.approx(speed / most, rel=0.02)


def test_air_that_flowed_in_is_in_the_chambers() -> None:
    """Mass from the flows against p V / (R T): jumps of two sizes, a ramp, a wave; none ends at the atmosphere."""
    t = DT * np.arange(4000)
    jumps = t % 1 > 0.5
    setpoints = np.column_stack([3e4 + 6e4 * jumps, 1e4 + 5e4 * t, 1e5 * (1.1 + np.sin(4 * t)), 2e4 + 22e4 * jumps])
    twin = TwinParameters()
    pressures, flows = run(twin, setpoints)
    brought = REFERENCE_DENSITY * DT * np.cumsum(flows, axis=0)
    assert brought == pytest.approx(pressures * twin.chamber_volume / (GAS * TEMPERATURE), rel=1e-3, abs=1e-9)


def test_a_small_step_rises_like_the_lag_of_the_paper() -> None:
    p = stepped(0.0, 60e3)
    assert 0.042 < time_constant(p, 0.0, 60e3) < 0.05
    lag = 60e3 * (1 - np.exp(-DT * (1 + np.arange(1000)) / 0.044))
    assert np.abs(p - lag).max() < 0.03 * 60e3
    assert np.all(np.diff(p[:200]) > 0)


@pytest.mark.parametrize("lag", [0.03, 0.06, 0.1])
def test_the_loops_have_the_lags_asked_for_where_they_are_tuned(lag: float) -> None:
    wanted = {
        "inflate_time": lag,
        "exhaust_time": lag,
        "valve_lag": 0.0,
        "valve_offset": 0.0,
        "valve_integral_time": 10.0,
    }
    filling = stepped(58e3, 62e3, **wanted)
    venting = stepped(62e3, 58e3, **wanted)
    assert time_constant(filling, 58e3, 62e3) == pytest.approx(lag, rel=0.04)
    assert time_constant(venting, 62e3, 58e3) == pytest.approx(lag, rel=0.04)


def test_exhaust_slows_down_as_the_pressure_that_drives_it_falls() -> None:
    measured = [time_constant(stepped(p, p - 10e3), p, p - 10e3) for p in (160e3, 80e3, 40e3, 20e3, 10e3)]
    assert np.all(np.diff(measured) > 0.004)
    assert measured[-1] > 3 * measured[0]


def test_from_full_pressure_the_open_valve_fills_faster_than_it_empties() -> None:
    assert time_constant(stepped(240e3, 0.0), 240e3, 0.0) > 1.5 * time_constant(stepped(0.0, 240e3), 0.0, 240e3)


def test_an_open_port_empties_a_choked_chamber_exponentially() -> None:
    """Isothermal choked discharge: absolute pressure falls with V / (REFERENCE_PRESSURE C)."""
    p = stepped(600e3, 0.0, exhaust_time=0.005, valve_lag=0.0, valve_offset=0.0, supply_pressure=1e6) + ATMOSPHERE
    choked = p[p > ATMOSPHERE / 0.3]
    tau = 5e-5 / (100e3 * 3.9e-9)
    assert choked.size > 50
    assert np.diff(np.log(choked)) == pytest.approx(np.full(choked.size - 1, -DT / tau), rel=0.01)


@pytest.mark.parametrize(
    ("start", "end"), [(0, 60e3), (60e3, 40e3), (100e3, 110e3), (110e3, 100e3), (0, 240e3), (240e3, 0)]
)
@pytest.mark.parametrize("offset", [-0.01, 0.0, 0.01])
def test_pressure_settles_on_the_setpoint_with_little_overshoot(start: float, end: float, offset: float) -> None:
    twin = TwinParameters(dead_time=0.0, valve_offset=offset, inflate_time=0.044, exhaust_time=0.05)
    p = run(twin, np.repeat([start, end], [8000, 8000]))[0][:, 0]
    assert p[[7999, 15999]] == pytest.approx([start, end], abs=5.0)
    beyond = (p[8000:] - end) * math.copysign(1, end - start)
    assert beyond.max() < 0.05 * abs(end - start)


def test_pressures_stay_between_atmosphere_and_supply() -> None:
    random = np.random.default_rng(3)
    setpoints = np.repeat(random.choice([-50e3, 0.0, 100e3, 900e3], size=(200, 4)), 40, axis=0)
    twin = TwinParameters(supply_pressure=300e3, chamber_volume=1e-6, conductance=1e-7)
    pressures, _ = run(twin, setpoints)
    assert pressures.min() == 0.0 and pressures.max() == 300e3


def test_a_chamber_at_rest_stays_empty_whatever_its_spools_offset() -> None:
    for offset in (-0.004, 0.004):
        assert not run(TwinParameters(valve_offset=offset), np.zeros(2000))[0].any()
