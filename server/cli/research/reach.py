"""`tendril reach` at the command line: how far an actuator reaches, in words, as a table and as a drawing."""

import csv
import io
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console

from controller.assembly.statics import static_map
from controller.reference.feasible.reach import Reach, reach_map, static_tips
from controller.schema.origin import comment_lines, origin
from controller.schema.parameters import RigParameters
from controller.system.origin import command_line
from server.cli.files import require_file, write, write_json

HEADER = ("u_1 [N m]", "u_2 [N m]", "x [m]", "y [m]")
SIDE = 41
"""Rows and columns of the grid that is drawn."""
INK, LIGHT = "#1f5fa8", "#cfe0f3"


class Files(NamedTuple):
    """What is asked for."""

    table: Path | None = None
    drawing: Path | None = None
    json: Path | None = None


def run_reach(parameters: RigParameters, files: Files, comments: bool, console: Console) -> None:
    """Say how far it reaches, and write what is asked for. TendrilError says what is wrong."""
    for file in filter(None, files):
        require_file(file)
    found = reach_map(parameters)
    rest = rest_tip(parameters)
    for line in described(parameters.actuator.name, found, rest):
        console.print(line, markup=False, soft_wrap=True, highlight=False)
    made = origin(command_line(), actuators=(parameters.actuator,), controller=parameters.controller)
    before = comment_lines(made if comments else None)
    if files.table is not None:
        write(files.table, as_csv(found, before))
    if files.drawing is not None:
        write(files.drawing, as_svg(parameters))
    if files.json is not None:
        write_json(files.json, figures(found, rest), made)
    for path in filter(None, files):
        console.print(f"Written: {path}", markup=False, soft_wrap=True, highlight=False)


def rest_tip(parameters: RigParameters) -> np.ndarray:
    """Where the tip (2,) [m] is without torques."""
    return static_tips(static_map(parameters.actuator, parameters.controller), np.zeros(2))


def described(name: str, found: Reach, rest: np.ndarray) -> list[str]:
    """The extent of the reach and of the torques, in mm and mN m."""
    (x_min, y_min), (x_max, y_max) = (1e3 * edge(found.p, axis=(0, 1)) for edge in (np.min, np.max))
    (low_1, low_2), (high_1, high_2) = (1e3 * edge(found.u, axis=(0, 1)) for edge in (np.min, np.max))
    return [
        f"{name}: at rest the tip is at ({1e3 * rest[0]:.1f}, {1e3 * rest[1]:.1f}) mm",
        f"reach: x {x_min:.1f} to {x_max:.1f} mm, y {y_min:.1f} to {y_max:.1f} mm",
        f"torques: u_1 {low_1:.1f} to {high_1:.1f} mN m, u_2 {low_2:.1f} to {high_2:.1f} mN m",
    ]


def figures(found: Reach, rest: np.ndarray) -> dict[str, object]:
    """The same in SI units: the tip at rest, and lowest and highest of x, y, u_1 and u_2."""
    ends = [(np.min(values, axis=(0, 1)), np.max(values, axis=(0, 1))) for values in (found.p, found.u)]
    names = (("x", "y"), ("u_1", "u_2"))
    spans = {
        name: [float(low[i]), float(high[i])]
        for pair, (low, high) in zip(names, ends, strict=True)
        for i, name in enumerate(pair)
    }
    return {"rest": rest.tolist(), **spans}


def as_csv(found: Reach, before: str = "") -> str:
    """One line a point of the grid, torques and tip; `before` are lines of comments."""
    text = io.StringIO()
    text.write(before)
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(HEADER)
    rows = np.concatenate([found.u, found.p], axis=-1).reshape(-1, 4)
    lines.writerows([f"{value:.7g}" for value in row] for row in rows.tolist())
    return text.getvalue()


def as_svg(parameters: RigParameters) -> str:
    """The reach as a surface, in mm; its hole, where it has one, stays open."""
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

    from controller.research.drawing import svg

    p, rest = 1e3 * reach_map(parameters, SIDE).p, 1e3 * rest_tip(parameters)

    def draw(figure: Figure) -> None:
        plane = figure.subplots()
        cells = np.zeros((SIDE - 1, SIDE - 1))
        plane.pcolormesh(p[..., 0], p[..., 1], cells, cmap=ListedColormap([LIGHT]), edgecolors="face")
        plane.plot(*rest, "o", color=INK, markersize=4.0, label="tip at rest")
        plane.plot(0.0, 0.0, "s", color=INK, markersize=4.0, label="base")
        plane.set(title=f"Reach of {parameters.actuator.name}", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
        plane.legend()

    return str(svg(draw, (4.0, 4.0)))
