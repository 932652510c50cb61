"""The simulated actuator: matched to the model when its flaws are off, and each flaw as its parameter says."""

import math
from typing import Any

import numpy as np
import pytest

from controller.arrays import Rows
from controller.assembly.rod import build_rod
from controller.assembly.stages import step_of
from controller.assembly.twin import build_twin
from controller.kernels.function_pointer import FunctionPointer, call
from controller.kernels.model.rod import make_load
from controller.kernels.model.statics import tip_of
from controller.kernels.plant.twin import Twin, twin_step
from controller.schema.actuator import PRESETS
from controller.schema.layout import record_dtype
from controller.schema.messages import Measurement, Telemetry
from controller.schema.modes import Integrator
from controller.schema.parameters import RigParameters, TwinParameters
from tests.controller.chains import advance, compiled, posed, static
from tests.controller.statically import static_tip

pytestmark = pytest.mark.keyed()

IDEAL = {
    "torque_gain": (1.0, 1.0),
    "set_curvature": (0.0, 0.0),
    "creep": (0.0, 0.0),
    "friction": 0.0,
    "hysteresis": 0.0,
    "marker_noise": 0.0,
}
STEP_NS = 1_000_000


@compiled
def walk(
    twin: Twin, step: FunctionPointer, pressures: np.ndarray, telemetry: np.ndarray, measurement: np.ndarray
) -> None:
    """One step for each row of `pressures` (n,4) [Pa], in its own row of telemetry and a held measurement."""
    for i in range(pressures.shape[0]):
        measurement[i] = measurement[max(i - 1, 0)]
        for j in range(4):
            telemetry[i].pressure_cmd[j] = pressures[i, j]
        call(step, ((twin.ticks[0] + 1) * 1_000_000, twin, telemetry[i], measurement[i]))


def run(twin: Twin, pressures: np.ndarray) -> tuple[Rows, Rows]:
    """What telemetry showed at the start of each tick and what was sensed after it (n,)."""
    telemetry = np.zeros(len(pressures), record_dtype(Telemetry))
    measurement = np.zeros(len(pressures), record_dtype(Measurement))
    walk(twin, step_of(twin), pressures, telemetry, measurement)
    return telemetry, measurement


def twin_of(name: str = "P1", **flaws: Any) -> Twin:
    return build_twin(RigParameters(actuator=PRESETS[name], twin=TwinParameters(**flaws)))


def held(pressures: tuple[float, float, float, float], seconds: float) -> np.ndarray:
    return np.tile(np.array(pressures), (round(seconds * 1000), 1))


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
@pytest.mark.parametrize("u", [(0.02, 0.015), (-0.01, 0.03)])
def test_without_flaws_the_tip_rests_where_the_model_says(name: str, u: tuple[float, float]) -> None:
    actuator = PRESETS[name]
    per_torque = actuator.pressure_map[0]
    p = (max(u[0], 0), max(-u[0], 0), max(u[1], 0), max(-u[1], 0))
    telemetry, measurement = run(twin_of(name, rods=10, **IDEAL), np.array(p) * per_torque * np.ones((8000, 1)))
    expected = static_tip(static(build_rod(actuator, 10)), *u)
    assert telemetry["twin_backbone"][-1, -1] == pytest.approx(expected, abs=1e-6)
    assert measurement["markers"][-1, -1] == pytest.approx(expected, abs=1e-6)


def test_the_twin_hangs_under_gravity_as_the_model_does() -> None:
    hanging = PRESETS["P1"].model_copy(update={"gravity": (0.0, -0.4), "alpha": 5.0})
    model = build_rod(hanging, 10)
    state = advance(model, posed(model, np.zeros(10), np.zeros(10)), make_load(10), 20.0)
    twin = build_twin(RigParameters(actuator=hanging, twin=TwinParameters(rods=10, **IDEAL)))
    telemetry, _ = run(twin, held((0.0, 0.0, 0.0, 0.0), 10.0))
    assert telemetry["twin_backbone"][-1, -1] == pytest.approx(tip_of(model, state.q), abs=1e-6)
    assert telemetry["twin_backbone"][-1, -1, 1] < -0.02


def test_torque_gain_is_the_mismatch_of_the_bend() -> None:
    telemetry, _ = run(twin_of(rods=10, **IDEAL | {"torque_gain": (1.2, 1.2)}), held((60e3, 0.0, 0.0, 0.0), 8.0))
    u = 1.2 * 60e3 / PRESETS["P1"].pressure_map[0]
    expected = static_tip(static(build_rod(PRESETS["P1"], 10)), u, 0.0)
    assert telemetry["twin_backbone"][-1, -1] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("chamber", "gain"), [(0, 1.2), (1, 0.8), (2, 1.0), (3, 1.0)])
def test_an_imbalance_bends_each_way_by_another_gain(chamber: int, gain: float) -> None:
    pressures = np.zeros(4)
    pressures[chamber] = 60e3
    twin = twin_of(rods=10, **IDEAL | {"chamber_imbalance": (0.2, 0.0)})
    telemetry, _ = run(twin, held(tuple(pressures), 8.0))
    u = np.zeros(2)
    u[chamber // 2] = (-1) ** chamber * gain * 60e3 / PRESETS["P1"].pressure_map[0]
    expected = static_tip(static(build_rod(PRESETS["P1"], 10)), *u)
    assert telemetry["twin_backbone"][-1, -1] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("actuator", ["P1", "P3"])
def test_the_set_bends_each_half_at_rest_by_its_curvature_times_its_length(actuator: str) -> None:
    base, tip = 0.6, -0.2
    ideal = IDEAL | {"set_curvature": (base, tip)}
    twin = build_twin(RigParameters(actuator=PRESETS[actuator], twin=TwinParameters(rods=20, **ideal)))
    length = PRESETS[actuator].length
    assert twin.model.rest[9] == pytest.approx(base * length * 9.5 / 20, rel=1e-9)
    assert twin.model.rest[-1] == pytest.approx(base * length / 2 + tip * length * 9.5 / 20, rel=1e-9)
    telemetry, _ = run(twin, held((0.0, 0.0, 0.0, 0.0), 1.0))
    assert telemetry["twin_backbone"][-1, -1] == pytest.approx(telemetry["twin_backbone"][0, -1], abs=1e-9)


def test_one_seed_gives_the_same_bits_and_another_does_not() -> None:
    pressures = held((50e3, 0.0, 0.0, 80e3), 1.0)
    first, again, other = (run(twin_of(seed=seed), pressures)[1].tobytes() for seed in (5, 5, 6))
    assert first == again != other


def test_markers_come_at_100_hz_late_and_stamped_with_their_capture() -> None:
    telemetry, measurement = run(twin_of(marker_noise=0.0), held((80e3, 0.0, 30e3, 0.0), 0.5))
    stamps = measurement["t_ns"]
    arrivals = np.flatnonzero(np.diff(stamps)) + 1
    assert np.all(np.diff(arrivals) == 10)
    assert np.all(stamps[4:] > 0)
    for i in arrivals:
        captured = stamps[i] // STEP_NS - 1
        assert i - captured == 4
        seen, true = measurement["markers"][i], telemetry["twin_backbone"][captured, 2::2]
        assert seen == pytest.approx(true, abs=1e-7)


def test_marker_noise_is_white_normal_and_of_the_size_asked_for() -> None:
    _, measurement = run(twin_of(marker_noise=2e-4, set_curvature=(0.0, 0.0)), held((0.0, 0.0, 0.0, 0.0), 20.0))
    at_rest = np.column_stack([0.253 * np.arange(1, 11) / 10, np.zeros(10)])
    noise = (measurement["markers"][10::10] - at_rest) / 2e-4
    count = noise.size
    assert abs(noise.mean()) < 4 / math.sqrt(count)
    assert noise.std() == pytest.approx(1.0, abs=4 / math.sqrt(2 * count))
    assert (noise**4).mean() == pytest.approx(3.0, abs=4 * math.sqrt(96 / count))
    assert abs((noise[1:] * noise[:-1]).mean()) < 4 / math.sqrt(count)
    assert abs((noise[:, :, 0] * noise[:, :, 1]).mean()) < 4 / math.sqrt(count / 2)


def test_chambers_wait_for_the_dead_time_and_exhaust_slower_than_they_fill() -> None:
    twin = twin_of(inflate_time=0.03, exhaust_time=0.06, dead_time=0.05)
    filling = run(twin, held((100e3, 0.0, 0.0, 0.0), 2.0))[1]["pressures"][:, 0]
    venting = run(twin, held((0.0, 0.0, 0.0, 0.0), 1.0))[1]["pressures"][:, 0]
    assert np.all(filling[:50] == 0.0)
    assert np.all(venting[:50] > 99.9e3)
    rise = int(np.argmax(filling[50:] >= 100e3 * (1 - math.exp(-1))))
    fall = int(np.argmax(venting[50:] <= 100e3 * math.exp(-1)))
    assert abs(rise - 30) <= 1
    assert fall == pytest.approx(60, rel=0.1)


def test_creep_moves_the_tip_on_after_the_step_but_not_where_it_ends() -> None:
    flaws = IDEAL | {"creep_time": (0.15, 1.0)}
    elastic, creeping = (
        run(twin_of(rods=10, **flaws | {"creep": creep}), held((60e3, 0.0, 0.0, 0.0), 12.0))[0]
        for creep in ((0.0, 0.0), (0.0, 0.2))
    )
    y_elastic, y_creeping = (rows["twin_backbone"][:, -1, 1] for rows in (elastic, creeping))
    assert y_creeping[1200] < y_elastic[1200] - 5e-3
    assert y_creeping[-1] == pytest.approx(y_elastic[-1], abs=2e-5)


def test_friction_stops_the_swing_sooner_and_short_of_the_static_pose() -> None:
    smooth, rough = (
        run(twin_of(rods=10, **IDEAL | {"friction": mu, "zeta": 0.05}), held((60e3, 0.0, 0.0, 0.0), 4.0))[0]
        for mu in (0.0, 0.16)
    )
    swing_smooth, swing_rough = (np.ptp(rows["twin_backbone"][2000:, -1, 1]) for rows in (smooth, rough))
    assert swing_rough < 0.2 * swing_smooth


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_the_plant_stays_finite_and_whole_under_the_wildest_valves(name: str) -> None:
    random = np.random.default_rng(1)
    actuator = PRESETS[name]
    pressures = np.repeat(random.choice([0.0, actuator.pressure_max], size=(600, 4)), 50, axis=0)
    twin = twin_of(name, zeta=0.05, friction=0.0, creep=(0.3, 0.3))
    telemetry, _ = run(twin, pressures)
    assert np.isfinite(telemetry["twin_backbone"]).all()
    gaps = np.linalg.norm(np.diff(telemetry["twin_backbone"], axis=1), axis=2)
    assert gaps.max() < 1.01 * actuator.length / 20


def test_a_step_of_the_twin_allocates_nothing() -> None:
    @compiled
    def step(twin: Twin, telemetry: np.ndarray, measurement: np.ndarray) -> None:
        twin_step(twin.ticks[0], twin, telemetry[0], measurement[0])

    step(twin_of(), np.zeros(1, record_dtype(Telemetry)), np.zeros(1, record_dtype(Measurement)))
    assert "NRT_MemInfo_alloc" not in "".join(step.inspect_llvm().values())


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_one_implicit_step_a_tick_moves_as_the_fine_steps_do_whatever_creeps(name: str) -> None:
    """Steps of pressure, with the fitted flaws and with branches stiffer than the hinges: 2 % of the way at most."""
    pressures = np.vstack([held((p, 0.0, q, 0.0), 0.5) for p, q in ((6e4, 3e4), (0.0, 9e4), (9e4, 0.0))])
    for flaws in ({}, {"creep": (0.8, 0.5), "hysteresis": 0.4}):
        tips = [
            run(twin_of(name, integrator=integrator, marker_noise=0.0, **flaws), pressures)[0]["twin_backbone"][:, -1]
            for integrator in Integrator
        ]
        way = np.linalg.norm(np.ptp(tips[0], axis=0))
        assert np.linalg.norm(tips[0] - tips[1], axis=1).max() < 0.02 * way
