"""How the data beside this file were made: python make_data.py FOLDER writes the same files again.

poses.csv and decays.csv are what a lab would measure of an arm like P1 with six times its stiffness, by the product's
own rod model of 40 rods, with 0.2 mm of noise on every coordinate. my_poses.csv and my_decays.csv are the same of an
arm of which base.toml knows little, with 100 rods: tapered, stiffer and longer under pressure, its chambers not alike.
spiral.csv is a path within the reach of P1, my_path.csv one for that arm, theirs.csv a circle as another lab's camera
might have seen it, in millimetres.
"""

import itertools
import sys
from pathlib import Path

import numpy as np

from controller.assembly.equilibrium import body_of, carrying, settle
from controller.assembly.rod import build_rod
from controller.kernels.model.implicit import implicit_step, make_implicit_work
from controller.kernels.model.rod import RodModel, make_load
from controller.kernels.model.statics import at_rest, pose
from controller.research.identification.poses import backbones, torques
from controller.schema.actuator import PRESETS, Actuator

RODS, FINE, NOISE = 40, 100, 2e-4
ARM = PRESETS["P1"].model_copy(update={"k": (0.45,), "b": (4e-4,), "alpha": 2.0})


YOURS = Actuator.model_validate(
    {
        "name": "yours",
        "mass": 0.050,
        "length": 0.200,
        "EI": [7e-3, 5e-3],
        "beta": 3e-3,
        "alpha": 1.0,
        "stiffening": [1.2e-6, 0.9e-6],
        "stretching": [1.8e-7, 2.2e-7],
        "u_max": 0.16,
        "pressure_map": [1.05e6, 1.15e6, 1.2e6, 1.08e6],
    }
)
HELD, OF_ONE, OF_OTHER = (0.0, 40e3, 80e3), (-80e3, 0.0, 80e3), (-100e3, -50e3, 0.0, 50e3, 100e3)
"""What both chambers of a pair hold, and what one of them gets on top [Pa]."""


def main(folder: Path) -> None:
    """Write all files into `folder`."""
    random = np.random.default_rng(1)
    model = build_rod(ARM, RODS)
    write(folder / "poses.csv", "p1_kpa,p2_kpa,x1_mm,y1_mm,x2_mm,y2_mm", poses(model, random), 3)
    write(folder / "decays.csv", "ID,x1,y1,x2,y2,x3,y3", decays(model, random), 5)
    markers = [f"{axis}{i}_mm" for i in range(1, 5) for axis in "xy"]
    write(folder / "my_poses.csv", ",".join(["p1_kpa,p2_kpa,p3_kpa,p4_kpa", *markers]), my_poses(random), 3)
    yours = build_rod(YOURS, FINE)
    write(folder / "my_decays.csv", "ID,x1,y1,x2,y2,x3,y3,x4,y4", decays(yours, random, 4, (0.25, 0.2)), 5)
    write(folder / "my_path.csv", "t,x,y", my_path(), 5)
    write(folder / "spiral.csv", "t,x,y", spiral(), 5)
    write(folder / "theirs.csv", "t,x,y", circle(), 3)


def poses(model: RodModel, random: np.random.Generator) -> np.ndarray:
    """Sixteen resting poses (16,6): pressures [kPa], and the middle and the tip [mm]."""
    rows = []
    for u in random.uniform(-0.06, 0.06, (16, 2)):
        points = bodies(model, settled(model, model.T_theta @ u), 2)
        noisy = points + random.normal(0.0, NOISE, points.shape)
        rows.append([*(1e-3 * u * np.array(ARM.pressure_map)), *(1e3 * noisy).ravel()])
    return np.array(rows)


def my_poses(random: np.random.Generator) -> np.ndarray:
    """45 resting poses (45,12) at three co-contractions: four pressures [kPa], and four markers [mm]."""
    model, rows = build_rod(YOURS, FINE), []
    for held, one, other in itertools.product(HELD, OF_ONE, OF_OTHER):
        p = np.array([held + max(side * more, 0.0) for more in (one, other) for side in (1.0, -1.0)])
        u, level = torques(YOURS, p[None])
        (joints,) = backbones(model, u, level)
        points = joints[:, FINE // 4 :: FINE // 4].T
        rows.append([*(1e-3 * p), *(1e3 * (points + random.normal(0.0, NOISE, points.shape))).ravel()])
    return np.array(rows)


def my_path() -> np.ndarray:
    """Two turns in eight seconds, 40 mm across: t, x, y [s, m], 50 a second."""
    t = np.arange(401) / 50
    return np.column_stack([t, 0.115 + 0.02 * np.sin(0.5 * np.pi * t), 0.12 + 0.02 * np.cos(0.5 * np.pi * t)])


def decays(
    model: RodModel, random: np.random.Generator, count: int = 3, shares: tuple[float, float] = (1.0, -0.5)
) -> np.ndarray:
    """Six releases (n,1 + 2 count), 100 samples a second: its number, then x, y of each body [m]."""
    rows = []
    for number, u in enumerate(random.uniform(0.02, 0.06, (6, 2)) * shares):
        for points in swing(model, model.T_theta @ u, count):
            rows.append([number, *(points + random.normal(0.0, NOISE, points.shape)).ravel()])
    return np.array(rows)


def swing(model: RodModel, held: np.ndarray, count: int, samples: int = 350) -> np.ndarray:
    """Bodies (samples,count,2) [m] of the arm that is let go of under these torques on the rods' angles."""
    state, load, work, seen = at_rest(model), make_load(model.L.size), make_implicit_work(model.L.size), []
    pose(model, settled(model, held), state.q)
    for _ in range(samples):
        seen.append(bodies(model, state.q[2], count))
        for _ in range(20):
            implicit_step(model, load, 5e-4, state, work)
    return np.array(seen)


def settled(model: RodModel, torque: np.ndarray) -> np.ndarray:
    """Angles (N,) at rest under a torque on each angle."""
    return settle(carrying(body_of(model), torque), model.rest)


def bodies(model: RodModel, theta: np.ndarray, count: int) -> np.ndarray:
    """Points (count,2) [m] at even arc lengths, the tip last."""
    ends = np.cumsum(model.L * np.array([np.cos(theta), np.sin(theta)]), axis=1)
    return np.array([[np.interp(s, np.cumsum(model.L), axis) for axis in ends] for s in arcs(model, count)])


def arcs(model: RodModel, count: int) -> np.ndarray:
    """Where the bodies are along the arm [m]."""
    return model.L.sum() * np.arange(1, count + 1) / count


def spiral() -> np.ndarray:
    """Three turns in six seconds, from 5 to 30 mm about a point that P1 reaches: t, x, y [s, m], 50 a second."""
    t = np.arange(301) / 50
    radius, angle = 5e-3 + 25e-3 * t / 6.0, np.pi * t
    return np.column_stack([t, 0.03 + radius * np.sin(angle), 0.14 + radius * np.cos(angle)])


def circle() -> np.ndarray:
    """Two turns in eight seconds, 60 mm across: t, x, y [s, mm], 50 a second."""
    t = np.arange(401) / 50
    return np.column_stack([t, 30.0 + 30.0 * np.sin(0.5 * np.pi * t), 140.0 + 30.0 * np.cos(0.5 * np.pi * t)])


def write(file: Path, header: str, rows: np.ndarray, digits: int) -> None:
    """A table that `tendril docs tables` describes."""
    lines = [",".join(f"{value:.{digits}f}".rstrip("0").rstrip(".") for value in row) for row in rows]
    file.write_text("\n".join([header, *lines]) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
