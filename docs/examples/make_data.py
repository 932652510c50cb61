"""How the data beside this file were made: python make_data.py FOLDER writes the same files again.

poses.csv and decays.csv are what a lab would measure of an arm like P1 with six times its stiffness, by the product's
own rod model of 40 rods, with 0.2 mm of noise on every coordinate. spiral.csv is a path within the reach of P1,
theirs.csv a circle as another lab's camera might have seen it, in millimetres.
"""

import sys
from pathlib import Path

import numpy as np

from controller.assembly.equilibrium import body_of, carrying, settle
from controller.assembly.rod import build_rod
from controller.kernels.model.implicit import implicit_step, make_implicit_work
from controller.kernels.model.rod import RodModel, make_load
from controller.kernels.model.statics import at_rest, pose
from controller.schema.actuator import PRESETS

RODS, NOISE = 40, 2e-4
ARM = PRESETS["P1"].model_copy(update={"k": (0.45,), "b": (4e-4,), "alpha": 2.0})


def main(folder: Path) -> None:
    """Write all four files into `folder`."""
    random = np.random.default_rng(1)
    model = build_rod(ARM, RODS)
    write(folder / "poses.csv", "p1_kpa,p2_kpa,x1_mm,y1_mm,x2_mm,y2_mm", poses(model, random), 3)
    write(folder / "decays.csv", "ID,x1,y1,x2,y2,x3,y3", decays(model, random), 5)
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


def decays(model: RodModel, random: np.random.Generator) -> np.ndarray:
    """Six releases (n,7), 100 samples a second: ID, and three bodies [m]."""
    rows = []
    for number, u in enumerate(random.uniform(0.02, 0.06, (6, 2)) * [1.0, -0.5]):
        for points in swing(model, model.T_theta @ u):
            rows.append([number, *(points + random.normal(0.0, NOISE, points.shape)).ravel()])
    return np.array(rows)


def swing(model: RodModel, held: np.ndarray, samples: int = 350) -> np.ndarray:
    """Bodies (samples,3,2) [m] of the arm that is let go of under these torques on the rods' angles."""
    state, load, work, seen = at_rest(model), make_load(RODS), make_implicit_work(RODS), []
    pose(model, settled(model, held), state.q)
    for _ in range(samples):
        seen.append(bodies(model, state.q[2], 3))
        for _ in range(20):
            implicit_step(model, load, 5e-4, state, work)
    return np.array(seen)


def settled(model: RodModel, torque: np.ndarray) -> np.ndarray:
    """Angles (RODS,) at rest under a torque on each angle."""
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
