"""The tick as a whole: complete, repeatable, free of allocation."""

from itertools import pairwise

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from controller.assembly.rig import build_rig
from controller.assembly.twin import build_twin
from controller.schema.messages import Command
from controller.schema.modes import Mode, Request
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.simulate import simulate
from tests.controller.trial import BOOT, Trial


def boot(seed: int) -> np.ndarray:
    """Two seconds of operation from a script, bit for bit."""
    random = np.random.default_rng(seed)
    script = [(100, Command(boot=BOOT, request_n=1, request=Request.ARM))]
    for n in range(2, 20):
        x, y = random.uniform(-0.3, 0.3, 2)
        mask, law = int(random.integers(0, 1024)), int(random.integers(0, 5))
        settings = Settings(sensed=mask, law=law, u_open=(x / 10, y / 10))
        request = Request.FOLLOW if n % 5 else Request.HOLD
        script.append((100 * n, Command(boot=BOOT, request_n=n, request=request, target=(x, y), settings=settings)))
    parameters = RigParameters()
    return np.asarray(simulate(build_rig(parameters, BOOT), build_twin(parameters), script, 2000))


def test_the_same_inputs_give_the_same_rows_bit_for_bit() -> None:
    assert boot(1).tobytes() == boot(1).tobytes()


def test_whatever_the_operator_does_every_number_stays_finite_and_admissible() -> None:
    for seed in range(6):
        rows = boot(seed)
        assert set(rows["mode"]) <= {Mode.VENTED, Mode.HOLD, Mode.FOLLOW}
        polygon = build_rig(RigParameters(), 1).control.smap.polygon
        assert ((rows["u"] @ polygon.normals.T) <= polygon.bounds * (1 + 1e-9)).all()
        for name in ("p_ref", "p_ref_dot", "p_hat", "error", "integral", "u_ff", "u_fb", "u_hat", "power", "backbone"):
            assert np.isfinite(rows[name]).all(), name
        assert np.abs(np.diff(rows["u"], axis=0)).max() < 20e-3


def test_the_tick_counts_itself_and_leaves_the_slot_to_the_loop() -> None:
    rows = boot(2)
    assert (np.diff(rows["tick"]) == 1).all()
    assert (rows["slot"] == np.arange(2000)).all()
    assert (rows["t_ns"][1:] - rows["t_ns"][:-1] == 1_000_000).all()


def test_the_backbone_in_telemetry_begins_at_the_clamp_and_ends_at_the_tip() -> None:
    trial = Trial()
    trial.arm()
    row = trial.follow(0.1, 0.14, 2.0)[-1]
    backbone = row["backbone"].astype(float)
    assert np.abs(backbone[0]).max() < 1e-5
    assert np.abs(backbone[-1] - row["p_hat"]).max() < 1e-6
    lengths = [np.hypot(*(b - a)) for a, b in pairwise(backbone)]
    assert np.ptp(lengths) < 5e-5


@pytest.mark.parametrize(("K_o", "B_o", "lost"), [(100.0, 0.0, 1e-4), (400.0, 0.5, 5e-3)])
def test_the_energy_ledger_closes_while_following(K_o: float, B_o: float, lost: float) -> None:
    """Backward steps lose more of what stiffer springs store, and add none."""
    trial = Trial(sensed=(1 << 9) | (1 << 5), K_o=(K_o, K_o), B_o=(B_o, B_o))
    trial.arm()
    rows = trial.follow(0.1, 0.14, 5.0)
    moved = np.abs(rows["power"]).sum() * 1e-3
    assert -lost * moved < rows["ledger"].min() and rows["ledger"].max() < 1e-4 * moved
    assert (rows["power"][:, 0] <= 0.0).all()


def test_the_tick_allocates_nothing() -> None:
    """Counted by numba's own memory system over a run with branch changes, saturation and a stop."""
    trial = Trial()
    trial.arm()
    _nrt_python.memsys_enable_stats()
    counts = []
    for ticks, target in ((1, (0.1, 0.1)), (2000, (0.1, -0.1)), (2000, (0.05, 0.0)), (2000, (0.4, 0.0))):
        before = rtsys.get_allocation_stats()
        trial.ask(Request.FOLLOW, target, ticks)
        counts.append(rtsys.get_allocation_stats().alloc - before.alloc)
    assert counts == [counts[0]] * 4
