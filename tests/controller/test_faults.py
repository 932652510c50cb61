"""Faults that are injected into the twin's sensing."""

import math

import numpy as np
import pytest

from controller.build_twin import build_twin
from controller.errors import CommandRefused
from controller.kernels.faults import MARKER_LOSS, NOISE, SAMPLE_LOSS
from controller.kernels.twin import Twin
from controller.messages import TwinFaults
from controller.parameters import RigParameters, TwinParameters
from controller.realtime.desk import Desk
from tests.controller.test_twin import run

ROD_6 = 5


def sensed(twin: Twin, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Times of capture (k,) [ns] and markers (k,10,2) [m] of the samples delivered in so many ticks at rest."""
    measurement = run(twin, np.zeros((ticks, 4)))[1]
    fresh = np.flatnonzero(np.diff(measurement["t_ns"], prepend=0))
    return measurement["t_ns"][fresh], measurement["markers"][fresh]


def twin(**values: float) -> Twin:
    built = build_twin(RigParameters(twin=TwinParameters(seed=3)))
    built.faults.rods[0] = TwinFaults().rods
    for name, value in values.items():
        built.faults.values[{"noise": NOISE, "sample_loss": SAMPLE_LOSS, "marker_loss": MARKER_LOSS}[name]] = value
    return built


def test_without_faults_and_of_what_they_leave_alone_every_bit_stays() -> None:
    plain, lossy = sensed(twin(), 2000), sensed(twin(marker_loss=0.3), 2000)
    seen = np.isfinite(lossy[1])
    assert np.array_equal(plain[1][seen], lossy[1][seen])
    assert abs(1.0 - seen.mean() - 0.3) < 4 * math.sqrt(0.3 * 0.7 / (seen.size / 2))
    only = twin(noise=1e-3)
    only.faults.rods[0] = 1 << ROD_6
    others = np.arange(10) != ROD_6
    noisy = sensed(only, 2000)[1]
    assert np.array_equal(plain[1][:, others], noisy[:, others])
    assert abs(np.std(noisy[:, ROD_6] - plain[1][:, ROD_6]) / 1e-3 - 1.0) < 0.15


def test_a_lost_sample_is_never_delivered_and_the_next_comes_in_its_time() -> None:
    plain, lossy = sensed(twin(), 4000), sensed(twin(sample_loss=0.5), 4000)
    assert set(lossy[0]) < set(plain[0])
    assert abs(len(lossy[0]) / len(plain[0]) - 0.5) < 4 * math.sqrt(0.25 / len(plain[0]))
    kept = np.isin(plain[0], lossy[0])
    assert np.array_equal(plain[1][kept], lossy[1])
    assert len(sensed(twin(sample_loss=1.0), 100)[0]) == 0


def test_a_rig_of_hardware_refuses_faults() -> None:
    desk = Desk(*[None] * 5)  # type: ignore[arg-type]
    with pytest.raises(CommandRefused, match="this rig is hardware"):
        desk.faults(TwinFaults(noise=1e-3))
