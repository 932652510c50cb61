"""A body that MuJoCo moves, an engine that we did not write, behind the Cosserat plant's valves, chambers and camera.

Its hinges are as stiff, and its elements as long, as that plant says that pressure makes them. `python -m
tests.controller.foreign_mujoco` prints what `tests.controller.foreign` does, with this body in static tests and runs.
"""

import importlib
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from controller.arrays import Array, Rows
from controller.assembly.cosserat import build_cosserat
from controller.assembly.rig import build_rig
from controller.kernels.model.rod import RodModel
from controller.kernels.plant.cosserat import Cosserat
from controller.reference.library import reference
from controller.research.bench.mujoco_chain import chain_xml
from controller.schema.actuator import Actuator
from controller.schema.messages import Command
from controller.schema.modes import Mode, Request
from controller.schema.parameters import CosseratParameters, RigParameters, TwinParameters
from controller.simulation.case import Case, Outcome, Setup, outcome, settings_of
from controller.simulation.run import for_reference, plan, request, require_mode, seeded
from controller.simulation.simulate import Simulation
from tests.controller.foreign import AtRest, Foreign, known_by, press, report

ELEMENTS = 20
FOREIGN = TwinParameters(plant="cosserat", cosserat=CosseratParameters(elements=ELEMENTS), friction=0.0)
SETUP = Setup(twin=FOREIGN)
SUBSTEPS = 25
"""Of MuJoCo in a period: its springs are explicit."""
PIECE, RESTING_MAX, MOVES_MAX = 100, 100, 1e-7
"""Periods after which a body in a static test is looked at, how often at most, and its way in between [m, rad]."""


class MujocoBody:
    """MuJoCo's chain of the Cosserat plant's elements, a hinge before each; its lengths follow the pressures."""

    def __init__(self, plant: Cosserat) -> None:
        mujoco: Any = importlib.import_module("mujoco")
        rod, n = plant.rod, plant.rod.m.size
        length = np.full(n, rod.l)
        chain = SimpleNamespace(
            m=rod.m, I=rod.I, L=length, arm=length, k=rod.k, b=rod.beta * rod.k, bend=rod.bend, g=rod.g
        )
        self._plant, self._step = plant, mujoco.mj_step
        self._model: Any = mujoco.MjModel.from_xml_string(chain_xml(cast(RodModel, chain), plant.dt / SUBSTEPS))
        self._model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self._data: Any = mujoco.MjData(self._model)
        self._before = self.ends(length)

    def advance(self) -> None:
        """Move for a period under what the plant's chambers do to it, and let the plant be where this body then is."""
        rod, forces, motion = self._plant.rod, self._plant.forces, self._plant.motion
        length = rod.l * (1.0 + forces.longer)
        self._model.jnt_stiffness[:] = forces.k.reshape(self._model.jnt_stiffness.shape)
        self._model.body_pos[2:, 0], self._model.body_ipos[1:, 0] = length[:-1], length
        self._data.qfrc_applied[:] = forces.moment
        self._data.xfrc_applied[1:, :2] = -rod.alpha * (rod.m * motion.v[:2]).T
        self._step(self._model, self._data, nstep=SUBSTEPS)
        now = self.ends(length)
        motion.q[:] = now
        motion.v[:] = (now - self._before) / self._plant.dt
        self._before = now

    def ends(self, length: Array) -> Array:
        """Free ends and angles (3,n) [m, rad] of the elements, which are so long (n,) [m]."""
        theta = np.cumsum(self._data.qpos)
        steps = length * np.array([np.cos(theta), np.sin(theta)])
        return np.vstack([steps.cumsum(axis=1), theta])


class MujocoSimulation(Simulation):
    """A rig before this body."""

    def __init__(self, parameters: RigParameters, command: Command) -> None:
        plant = build_cosserat(parameters)
        super().__init__(build_rig(parameters, 1), plant, command)
        self._body = MujocoBody(plant)

    def fill(self, out_rows: Rows) -> None:
        """A tick at a time."""
        for n in range(len(out_rows)):
            super().fill(out_rows[n : n + 1])
            self._body.advance()


def at_rest(actuator: Actuator) -> AtRest:
    """Of the body that MuJoCo moves."""
    parameters = RigParameters(actuator=actuator, twin=FOREIGN)

    def markers(pressure: Array) -> Array:
        plant = build_cosserat(parameters)
        body, every = MujocoBody(plant), plant.every[0]
        press(plant, pressure)
        ends = plant.motion.q.copy()
        for _ in range(RESTING_MAX):
            before = ends
            for _ in range(PIECE):
                body.advance()
            ends = plant.motion.q.copy()
            if np.abs(ends - before).max() < MOVES_MAX:
                return np.asarray(ends[:2, every - 1 :: every].T)
        raise AssertionError("the body does not come to rest")

    return markers


def followed(case: Case, model: Actuator, body: Actuator) -> Outcome:
    """`case` with `model` in observer and controller, on this plant of `body`."""
    path, parameters = reference(case.reference, model, SETUP.controller), known_by(model, case, body, SETUP)
    settings = for_reference(settings_of(case, SETUP.gains), path)
    simulation = MujocoSimulation(seeded(parameters, case.seed), Command(boot=1, settings=settings))
    simulation.run(50)
    request(simulation, Request.ARM)
    simulation.run(50)
    plan(simulation.rig.control, path)
    request(simulation, Request.TRACK)
    rows = simulation.run(len(path.p))
    require_mode(rows, path.name, Mode.TRACK, parameters.controller.dt)
    return outcome(case, path, rows)


MUJOCO = Foreign(at_rest, followed)

if __name__ == "__main__":
    report(MUJOCO)
