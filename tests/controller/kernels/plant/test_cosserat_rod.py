"""The Cosserat rod against an exact elastica, beam theory, its own energy, and two engines that we did not write."""

import importlib
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from controller.arrays import Array
from controller.assembly.cosserat import cosserat_rod, damped, first_frequency, rest_of, still
from controller.assembly.rod import build_rod
from controller.assembly.stability import natural_modes
from controller.kernels.plant.cosserat_rod import CosseratRod
from controller.research.bench.mujoco_chain import MujocoChain
from controller.schema.actuator import PRESETS
from controller.schema.parameters import CosseratParameters, TwinParameters
from tests.controller.cosserat_rods import EI, LENGTH, even, rod_of, straight, struck, tip_course

INEXTENSIBLE = {"stretch": 1e7, "shear": 1e7}


def exact_tip(rod: CosseratRod, F: Array) -> Array:
    """Tip (2,) [m] of the clamped rod under the force F (2,) [N] at its tip, by Reissner's equations."""

    def slopes(s: Array, state: Array) -> Array:
        theta, M, _, _ = state
        t, n = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
        x, y = (1.0 + (F @ t) / rod.EA) * t + (F @ n) / rod.GA * n
        return np.array([M / EI, -(x * F[1] - y * F[0]), x, y])

    def ends(base: Array, tip: Array) -> Array:
        return np.array([base[0], base[2], base[3], tip[1]])

    s = np.linspace(0.0, LENGTH, 200)
    found = solve_bvp(slopes, ends, s, np.array([0.5 * s / LENGTH, 0 * s, s, 0 * s]), tol=1e-10, max_nodes=100_000)
    assert found.success
    return np.asarray(found.y[2:, -1])


@pytest.mark.parametrize("own", [{}, {"stretch": 100.0, "shear": 40.0}], ids=["of rubber", "soft to stretch and shear"])
def test_a_cantilever_under_a_tip_force_is_the_exact_one_with_order_two(own: dict[str, float]) -> None:
    F, errors = np.array([-0.04, 0.12]), []
    for elements in (20, 40, 80):
        rod = rod_of(even(), elements=elements, **own)
        forces = still(rod)
        forces.F[:, -1] = F
        errors.append(float(np.linalg.norm(rest_of(rod, forces)[:2, -1] - exact_tip(rod, F))))
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_a_moment_of_the_chambers_bends_their_half_into_an_arc_and_leaves_the_other_straight() -> None:
    rod, u = rod_of(even(), elements=100), 0.02
    forces = still(rod)
    forces.moment[:50] = u
    forces.moment[50] = u / 2
    half, turn = LENGTH / 2, u * LENGTH / (2 * EI)
    middle = half / turn * np.array([math.sin(turn), 1.0 - math.cos(turn)])
    tip = middle + half * np.array([math.cos(turn), math.sin(turn)])
    pose = rest_of(rod, forces)
    assert pose[:2, 49] == pytest.approx(middle, abs=2e-5)
    assert pose[:2, 99] == pytest.approx(tip, abs=4e-5)


def test_the_first_mode_is_that_of_beam_theory() -> None:
    rod = rod_of(even(), elements=100, **INEXTENSIBLE)
    omega = 1.875104**2 * math.sqrt(EI / (PRESETS["P1"].mass * LENGTH**3))
    assert first_frequency(rod, straight(rod).q) == pytest.approx(omega, rel=1e-3)


LOADED = {"gravity": (3.0, -2.0), "tip_load": 0.02, "rest_curvature": (3.0, -1.0), "mass_profile": (1.5, 0.5)}


def test_gravity_tip_load_rest_curvature_and_mass_profile_are_those_of_a_fine_chain() -> None:
    actuator = even(**LOADED)
    rod = rod_of(actuator, elements=100, **INEXTENSIBLE)
    chain = build_rod(actuator, 60)._replace(alpha=0.0)
    rest = rest_of(rod)
    tip = (chain.L * np.array([np.cos(chain.rest), np.sin(chain.rest)])).sum(axis=1)
    assert rest[:2, -1] == pytest.approx(tip, abs=1e-4)
    omega = float(np.abs(natural_modes(chain, chain.rest)).min())
    assert first_frequency(rod, rest) == pytest.approx(omega, rel=2e-3)


@pytest.mark.parametrize("actuator", [even(), even(**LOADED)], ids=["plain", "loaded"])
@pytest.mark.parametrize("h", [1e-3, 10e-3])
def test_without_damping_the_energy_is_kept_by_any_step(actuator: Any, h: float) -> None:
    rod = rod_of(actuator)
    motion = struck(rod, 1.5)
    _, energies = tip_course(rod, motion, 2.0, h)
    assert np.ptp(energies) < 1e-8 * np.abs(energies).max()
    assert np.abs(motion.q).max() > 0.05


@pytest.mark.parametrize("damping", [{"alpha": 2.0}, {"beta": 0.2}, {"alpha": 2.0, "beta": 0.2}])
@pytest.mark.parametrize("h", [1e-3, 10e-3])
def test_with_damping_the_energy_falls_at_every_step(damping: dict[str, float], h: float) -> None:
    rod = rod_of(even())._replace(**damping)
    energies = tip_course(rod, struck(rod, 1.5), 2.0, h)[1]
    assert (np.diff(energies) <= 1e-12 * energies[0]).all()
    assert energies[-1] < 0.1 * energies[0]


def test_the_tip_converges_with_order_two_in_the_step() -> None:
    rod = rod_of(even())._replace(beta=5e-3)
    fine = tip_course(rod, struck(rod, 1.0), 0.2, 0.125e-3)[0][-1]
    errors = [float(np.linalg.norm(tip_course(rod, struck(rod, 1.0), 0.2, h)[0][-1] - fine)) for h in (2e-3, 1e-3)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] < 1e-4


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_the_first_mode_has_the_damping_ratio_that_was_asked_for(name: str) -> None:
    twin = TwinParameters(zeta=0.1, cosserat=CosseratParameters(viscosity=0.5))
    rod = cosserat_rod(PRESETS[name], twin)
    rest = rest_of(rod)
    ringing = damped(rod, rest, twin, 0.1)
    tip = tip_course(ringing, struck(ringing, 1e-3), 1.0, 1e-3)[0][:, 1]
    peaks = np.flatnonzero((tip[1:-1] > tip[:-2]) & (tip[1:-1] >= tip[2:])) + 1
    decrement = math.log(tip[peaks[0]] / tip[peaks[1]])
    assert decrement / math.sqrt(4 * math.pi**2 + decrement**2) == pytest.approx(0.1, rel=0.05)


def test_the_inextensible_limit_moves_as_a_chain_of_many_hinges_does_in_mujoco() -> None:
    u, beta = 0.01, 1e-4
    chain = build_rod(even(beta=beta), 40)._replace(alpha=0.0)
    theirs, held = MujocoChain(chain, 1e-4), np.zeros(40)
    held[-1] = u
    theirs.load(held)
    rod = rod_of(even(), elements=40, **INEXTENSIBLE)._replace(beta=beta)
    forces = still(rod)
    forces.moment[:] = u
    ours = tip_course(rod, straight(rod), 0.6, 1e-3, forces)[0]
    for tip in ours[9::10]:
        theirs.step(100)
        assert tip == pytest.approx(theirs.tip(), abs=1.5e-3)
    assert np.ptp(ours[:, 1]) > 0.15, "it moves far"


@pytest.mark.long  # its kernels take half a minute to compile
def test_a_struck_rod_rings_as_in_pyelastica() -> None:
    elastica: Any = pytest.importorskip("elastica", reason="the extra `engines` is not installed")
    theirs = Elastica(elastica)
    rod = theirs.as_ours()
    motion = struck(rod, 0.5)
    theirs.strike(motion.v)
    ours = tip_course(rod, motion, 1.0, 1e-3)[0]
    tips = np.array([theirs.run(1e-3) for _ in range(len(ours))])
    size = np.abs(tips[:, 1]).max()
    assert size > 0.05
    assert np.abs(ours - tips).max() < 0.02 * size
    assert crossings(ours[:, 1]) == pytest.approx(crossings(tips[:, 1]), rel=3e-3)


def crossings(y: Array) -> Array:
    """When y (n,) passes zero [samples]."""
    i = np.flatnonzero(np.diff(np.sign(y)))
    return np.asarray(i - y[i] / (y[i + 1] - y[i]))


class Elastica:
    """PyElastica's rod, clamped by one more element before the base; 1 ms takes steps of 50 us there."""

    N, DT, RADIUS = 20, 5e-5, 0.006

    def __init__(self, elastica: Any) -> None:
        parts = (elastica.BaseSystemCollection, elastica.Constraints)
        self._simulator: Any = type("Simulator", parts, {})()
        cell, area = LENGTH / self.N, math.pi * self.RADIUS**2
        self._rod = elastica.CosseratRod.straight_rod(
            n_elements=self.N + 1,
            start=np.array([-cell, 0.0, 0.0]),
            direction=np.array([1.0, 0.0, 0.0]),
            normal=np.array([0.0, 0.0, 1.0]),
            base_length=cell * (self.N + 1),
            base_radius=self.RADIUS,
            density=PRESETS["P1"].mass / (LENGTH * area),
            youngs_modulus=EI / (math.pi * self.RADIUS**4 / 4),
        )
        self._simulator.append(self._rod)
        self._simulator.constrain(self._rod).using(
            elastica.FixedConstraint, constrained_position_idx=(0, 1), constrained_director_idx=(0,)
        )
        self._simulator.finalize()
        self._stepper, self._now = importlib.import_module("elastica").PositionVerlet(), np.float64(0.0)

    def as_ours(self) -> CosseratRod:
        """Our rod with its masses and stiffnesses; its first bend is a whole cell's."""
        theirs, n, cell = self._rod, self.N, LENGTH / self.N
        return CosseratRod(
            l=cell,
            m=theirs.mass[2:].copy(),
            I=theirs.mass_second_moment_of_inertia[0, 0, 1:].copy(),
            EA=float(theirs.shear_matrix[2, 2, 0]),
            GA=float(theirs.shear_matrix[0, 0, 0]),
            k=np.full(n, EI / cell),
            bend=np.zeros(n),
            alpha=0.0,
            beta=0.0,
            g=np.zeros(2),
        )

    def strike(self, v: Array) -> None:
        """Give it the velocities v (3,n): the first director is the normal of the plane."""
        self._rod.velocity_collection[:2, 2:] = v[:2]
        self._rod.omega_collection[0, 1:] = v[2]

    def run(self, seconds: float) -> Array:
        """The tip (2,) [m] after `seconds`."""
        for _ in range(round(seconds / self.DT)):
            self._now = self._stepper.step(self._simulator, self._now, self.DT)
        return np.asarray(self._rod.position_collection[:2, -1].copy())
