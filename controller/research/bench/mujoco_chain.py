"""The same hinge chain in MuJoCo: an engine that we did not write, to check and to time the rod model against."""

import importlib
from typing import Any

import numpy as np

from controller.arrays import Array
from controller.errors import TendrilError
from controller.kernels.model.rod import RodModel
from controller.system.origin import install_command


def lacks_mujoco() -> str:
    """Why there is no mujoco, and how to get it; "" where there is one."""
    try:
        importlib.import_module("mujoco")
    except ImportError:
        return f"mujoco is not installed: {install_command('bench')}"
    return ""


class MujocoChain:
    """MuJoCo's RK4 on the hinges of `model` (relative angles; without mass damping), at rest along +x."""

    def __init__(self, model: RodModel, dt: float) -> None:
        if lacks := lacks_mujoco():
            raise TendrilError(lacks)
        self._mujoco: Any = importlib.import_module("mujoco")
        self._length = model.L
        self._model: Any = self._mujoco.MjModel.from_xml_string(chain_xml(model, dt))
        self._data: Any = self._mujoco.MjData(self._model)

    def load(self, Q_theta: Array) -> None:
        """Hold the torques `Q_theta` (N,) [N m] on the absolute angles: a joint carries all that act beyond it."""
        self._data.qfrc_applied[:] = np.cumsum(Q_theta[::-1])[::-1]

    def step(self, count: int = 1) -> None:
        """Advance by `count` steps."""
        self._mujoco.mj_step(self._model, self._data, nstep=count)

    def tip(self) -> Array:
        """Position of the free end (2,) [m]."""
        theta = np.cumsum(self._data.qpos)
        return np.array([self._length @ np.cos(theta), self._length @ np.sin(theta)])


def chain_xml(model: RodModel, dt: float) -> str:
    """MuJoCo's description of the chain: nested bodies, one hinge about z each, no contacts and no constraints."""
    bodies, before = "", 0.0
    columns = (model.m, model.I, model.L, model.arm, model.k, model.b, model.bend)
    for m, I, L, arm, k, b, bend in zip(*columns, strict=True):  # noqa: E741
        bodies += (
            f'<body pos="{before} 0 0">'
            f'<joint type="hinge" axis="0 0 1" stiffness="{k}" damping="{b}" springref="{bend}"/>'
            f'<inertial pos="{arm} 0 0" mass="{m}" diaginertia="{I} {I} {I}"/>'
        )
        before = L
    gravity = f"{model.g[0]} {model.g[1]} 0"
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="{gravity}" timestep="{dt}" integrator="RK4">'
        '<flag contact="disable" constraint="disable"/></option>'
        f"<worldbody>{bodies}{'</body>' * model.L.size}</worldbody></mujoco>"
    )
