"""The observer over recordings is the live one: same law, and compared with a sample before that sample has pulled."""

import math

import numpy as np

from controller.assembly.rig import build_rig
from controller.kernels.model.implicit import make_implicit_work
from controller.kernels.model.rod import make_load
from controller.kernels.model.statics import at_rest, points_on
from controller.kernels.observer.observer import Replay, observe
from controller.kernels.observer.replay import RecordedSamples, replay
from controller.schema.actuator import PRESETS
from controller.schema.layout import to_record
from controller.schema.messages import Measurement
from controller.schema.parameters import DT, ControllerParameters, RigParameters, Settings

PERIOD_TICKS, COUNT, TIP, OLD = 10, 40, 9, 0.05
GAINS = Settings()


def wave() -> np.ndarray:
    """A tip that swings across (COUNT,2) [m]."""
    t = DT * PERIOD_TICKS * np.arange(COUNT)
    return np.stack([0.25 - 0.2 * t**2, 0.05 * np.sin(12 * t)], axis=1)


def speed(tip: np.ndarray) -> np.ndarray:
    v = np.zeros_like(tip)
    v[1:] = np.diff(tip, axis=0) / (PERIOD_TICKS * DT)
    return v


def live(tip: np.ndarray) -> np.ndarray:
    """Points of the rig's own observer (COUNT,10,2) [m], before it has the sample of that time."""
    rig = build_rig(RigParameters(actuator=PRESETS["P1"], controller=ControllerParameters(predict=False)), 1)
    observer = rig.observer._replace(pull_max=math.inf)
    sensing, state, settings = rig.sensing, rig.control.state[0], to_record(GAINS)[0]
    state["used"], measurement = 1 << TIP, to_record(Measurement())[0]
    found, v = np.empty((COUNT, 10, 2)), speed(tip)
    for k in range(COUNT):
        points_on(observer.state.q, observer.sensors, found[k])
        sensing.p[TIP], sensing.v[TIP] = tip[k], v[k]
        for step in range(PERIOD_TICKS):
            sensing.age[0] = step * DT + 0.5 * DT  # as `sense` has it
            observe(0, settings, measurement, 1, sensing, rig.control, observer)
    return found


def recorded(tip: np.ndarray, ticks: int = PERIOD_TICKS, old: float = OLD) -> np.ndarray:
    observer = build_rig(RigParameters(actuator=PRESETS["P1"]), 1).observer
    rods, load = observer.model.L.size, make_load(observer.model.L.size, 10)
    load.springs.K[:], load.springs.B[:] = GAINS.K_o, GAINS.B_o
    run = Replay(
        observer.model, at_rest(observer.model), load, make_implicit_work(rods, 10), observer.sensors,
        np.zeros(rods), np.array([0.0, 1e-3]), DT,
    )  # fmt: skip
    p, v, out = np.full((COUNT, 10, 2), np.nan), np.zeros((COUNT, 10, 2)), np.empty((COUNT, 10, 2))
    p[:, TIP], v[:, TIP] = tip, speed(tip)
    replay(1 << TIP, RecordedSamples(p, v, np.full(COUNT, ticks, np.int64), old), run, out)
    return out


def test_a_recording_is_observed_bit_for_bit_as_the_rig_observes_it_live() -> None:
    assert np.array_equal(recorded(wave()), live(wave()))


def test_the_estimate_for_a_sample_is_made_by_earlier_samples_alone() -> None:
    last, other = wave(), wave()
    other[-1] += 0.1
    assert np.array_equal(recorded(last), recorded(other))
    other[-2] += 0.01
    assert not np.array_equal(recorded(last)[-1], recorded(other)[-1])


def test_a_sample_that_is_too_old_pulls_no_more() -> None:
    short, long = recorded(wave(), 60, 0.05), recorded(wave(), 60, 1.0)
    assert np.abs(short[5:, TIP] - long[5:, TIP]).max() > 1e-3
    assert np.array_equal(recorded(wave(), 50, 0.05), recorded(wave(), 50, 1.0))
