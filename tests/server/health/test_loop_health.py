"""What the health panel says about the loop, against ticks whose timing and lag are known."""

import numpy as np
import pytest

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from server.health.loop_health import EDGES, LAG_TICKS, LoopWatch, fitted_lag


def rows(count: int, dt: float = 1e-3) -> np.ndarray:
    found = np.zeros(count, record_dtype(Telemetry))
    found["tick"] = found["slot"] = np.arange(count)
    found["t_ns"] = 7_000_000_000 + np.arange(count) * round(1e9 * dt)
    return found


def test_lateness_is_counted_tick_by_tick_and_lost_slots_are_seen() -> None:
    ticks = rows(10_000)
    ticks["lateness_ns"] = 20_000
    ticks["lateness_ns"][::50] = 3_000_000
    ticks["step_ns"] = 80_000
    ticks["slot"][5000:] += 7
    watch = LoopWatch()
    watch.add(ticks)
    found = watch.health()
    assert found.lateness is not None
    assert found.step is not None
    assert found.lateness.median == pytest.approx(20e-6)
    assert found.lateness.p99 == pytest.approx(3e-3)
    assert found.step.largest == pytest.approx(80e-6)
    assert (found.ticks, found.lost) == (10_000, 7)
    assert sum(found.counts) == 10_000
    assert found.counts[np.searchsorted(EDGES, 3e-3) - 1] == 200
    assert found.pressure is None, "nothing moved"


def test_nothing_heard_yet_is_no_error_and_a_restart_begins_anew() -> None:
    watch = LoopWatch()
    found = watch.health()
    assert (found.ticks, found.lost, found.lateness, found.pressure) == (0, 0, None, None)
    for _ in range(2):
        for batch in np.array_split(rows(2 * LAG_TICKS), 100):
            watch.add(batch)
    assert (watch.health().ticks, watch.health().lost) == (10_000, 0)
    watch.add(rows(30))
    assert watch.health().ticks == 30


@pytest.mark.parametrize(("dead", "tau"), [(0.05, 0.05), (0.0, 0.12), (0.03, 0.02)])
def test_dead_time_and_time_constants_of_a_known_lag_are_found(dead: float, tau: float) -> None:
    h = 0.005
    t = h * np.arange(2000)
    command = 60e3 + 30e3 * np.sign(np.sin(1.3 * t))[:, None] * [1.0, 0.5, 0.2, 0.0]
    measured = np.zeros_like(command)
    for i in range(1, len(t)):
        late = command[max(0, i - 1 - round(dead / h))]
        slower = np.where(measured[i - 1] > late, 2.0, 1.0)
        measured[i] = late + (measured[i - 1] - late) * np.exp(-h / tau / slower)
    lag = fitted_lag(command, measured, h)
    assert lag is not None
    assert lag.dead_time == pytest.approx(dead, abs=1.01 * h)
    assert lag.filling == pytest.approx(tau, rel=0.15)
    assert lag.exhausting == pytest.approx(2.0 * tau, rel=0.15)
    assert lag.explained > 0.95


@pytest.mark.parametrize("dt", [1e-4, 5e-4, 1e-3, 2e-3, 1e-2])
def test_the_lag_is_told_in_seconds_whatever_the_loops_period(dt: float) -> None:
    """At 2 ms a lag of 50 ms was shown as one of 25 ms."""
    ticks = rows(30_000, dt)
    t, command, tau, late = dt * np.arange(30_000), ticks["pressure_cmd"], 0.05, round(0.04 / dt)
    command[:] = 60e3 + 30e3 * np.sign(np.sin(4.1 * t))[:, None] * [1.0, 0.5, 0.2, 0.0]
    for i in range(1, len(t)):
        wanted = command[max(0, i - 1 - late)]
        ticks["pressure_meas"][i] = wanted + (ticks["pressure_meas"][i - 1] - wanted) * np.exp(-dt / tau)
    ticks = np.delete(ticks, 5000)
    watch = LoopWatch()
    watch.add(ticks)
    lag = watch.health().pressure
    assert lag is not None
    assert lag.dead_time == pytest.approx(0.04, abs=0.011)
    assert lag.filling == pytest.approx(tau, rel=0.15) and lag.exhausting == pytest.approx(tau, rel=0.15)


def test_pressures_that_do_not_move_as_a_lag_has_it_give_no_number() -> None:
    noise = np.random.default_rng(1).normal(0.0, 5e3, (2000, 4))
    assert fitted_lag(np.zeros((2000, 4)) + 50e3, noise, 0.005) is None
