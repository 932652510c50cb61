"""Choices of an operator that would make the arm whip, or leave no rig to start."""

import time

import numpy as np

from controller.schema.actuator import PRESETS, Actuator
from controller.schema.fit import GAINS
from controller.schema.modes import Cause, Mode
from server.access.permit import Permit
from server.campaign import trace
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require, wait
from server.hardware.messages import ActuatorBody
from server.hardware.restart_files import request_actuator

WHIP = 0.06
"""Error from which on the arm whips: five times that of the circle [m]."""
SLACK = 8.0
"""After which a reaction is not waited for any more [s]."""
TOPPLED = {
    "name": "toppled",
    "mass": 10.0,
    "length": 2.0,
    "table_rods": 2,
    "k": 5.0,
    "gravity": (-9.81, 0.0),
    "chambers": ((0, 1), (1, 2)),
}
"""Gravity topples it: neither observer nor twin has a rest."""

UNASKED = Permit(None, lambda request: "")
"""For an order past the page's check."""


def gains_hard(scene: Scene) -> Seen:
    """The page allows them; they are put back afterwards."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    scene.operator.ask("PATCH", "/api/settings", changes={"K_I": [20.0, 20.0]})
    try:
        row = scene.until(start, (Mode.REST, Mode.FAULT, Mode.E_STOP), SLACK)
        require(row["cause"] in (Cause.OSCILLATION, Cause.TRACKING_RMS), f"{trace.told(row)} for gains")
        line = scene.operator.sees("rig: REST", mark)
        scene.stays_calm()
    finally:
        scene.operator.ask("PATCH", "/api/settings", changes={"K_I": [GAINS["K_I"]] * 2})
    rows = scene.since(start)
    rows = rows[rows["t_ns"] <= row["t_ns"]]
    error = np.hypot(*rows["error"].T)
    whips = rows["t_ns"][error > WHIP]
    since = float(row["t_ns"] - whips[0]) * 1e-6 if whips.size else 0.0
    scene.acts_again()
    return Seen(f"{trace.told(row)}, error at most {1e3 * error.max():.0f} mm; page: {line}", since)


def actuator_unbuildable(scene: Scene) -> Seen:
    """First as the page asks for it, then past the check, as if that had been wrong."""
    scene.operator.reconnect()
    for request in ("e_stop", "clear"):
        scene.operator.command(request)
    wait(lambda: scene.mode == Mode.VENTED, 5.0, "VENTED")
    toml = "\n".join(f"{name} = {written(value)}" for name, value in TOPPLED.items()) + "\nb = 0.0"
    refused = scene.operator.request("PUT", "/api/rig/actuator", toml=toml)
    require(refused.status_code == 422 and "gravity" in refused.text, f"{refused.status_code}: {refused.text}")
    boot, mark, start = scene.boot, len(scene.operator.log), time.monotonic_ns()
    fields = PRESETS["P1"].model_dump() | TOPPLED
    request_actuator(scene.restarts, Actuator.model_validate(fields), ActuatorBody(toml=toml), UNASKED)
    line = scene.operator.sees("actuator toppled did not start", mark, 30.0)
    scene.operator.sees("the rig restarted", mark, 30.0)
    require(scene.boot not in (0, boot), "the rig was not started again")
    took = (time.monotonic_ns() - start) * 1e-6
    require("P1 is in force again" in line, line)
    scene.acts_again()
    return Seen(f"refused: {refused.json()['detail'][:60]} ...; ordered all the same, page: {line}", took)


def written(value: object) -> str:
    """As TOML has it."""
    return f'"{value}"' if isinstance(value, str) else str(value).replace("(", "[").replace(")", "]")
