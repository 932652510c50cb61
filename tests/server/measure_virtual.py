"""`python -m tests.server.measure_virtual [REPEATS]`: the same tasks on the in-loop twin and over real wires.

Prints, for NatNet with the serial board and with a Festo terminal: every task's RMSE and its ratio to the twin's, the
time from a target to the tip's motion, lost ticks, injected and shown latency, memory and processor time.
"""

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from controller.realtime.ring import find_ring
from controller.schema.modes import Mode
from server.campaign.rows.wires import MODBUS, SERIAL
from tests.server.virtual_stack import Stack, stack

TASKS = (
    "step",
    "vu",
    "digit_2",
    "vertical_1hz",
    "horizontal_1hz",
    "circle_0.25hz",
    "circle_1hz",
    "sensing_sweep",
    "sensing_circle",
    "sensing_vertical",
)
"""Of the paper's tasks 1 to 4, the last three with rod 6 alone; task 5 is the hand's."""
ROD_6 = 1 << 5
TIP = 1 << 9
HAND = ((0.2, 0.06), (0.17, 0.1), (0.21, 0.0), (0.18, -0.08))
"""Where the hand goes, by turns [m]."""
MOVED = 2e-3
"""The tip has moved [m]."""
INJECTED = (0.0, 0.005, 0.02)
"""Later than the camera's own latency by so much [s]."""


def rmse(one: Stack, task: str) -> float:
    """Of one run [mm]; nan where it was broken off, which is said."""
    sensed = ROD_6 if task.startswith("sensing") else TIP
    one.person.ask("PATCH", "/api/settings", changes={"sensed": sensed})
    found = one.run(task)
    if found["state"] == "done":
        return 1e3 * float(found["rmse"])
    print(f"{one.name}: {task} {found['state']}: {found['reason']}", flush=True)
    one.arm()
    return float("nan")


def drag_ms(one: Stack, presses: int = 64) -> list[float]:
    """From the tick that has a new target to the one in which the measured tip has moved [ms]."""
    one.person.ask("PATCH", "/api/settings", changes={"sensed": TIP})
    found, ring = [], find_ring(one.name)
    for i in range(presses):
        x, y = HAND[i % len(HAND)]
        since = time.monotonic_ns()
        one.person.command("follow", target=(x, y))
        time.sleep(1.6)
        _, rows = ring.read(max(0, ring.head - 4000), 4000)
        rows = rows[rows["t_ns"] > since]
        new = np.flatnonzero(np.hypot(*(rows["target"] - (x, y)).T) < 1e-9)
        if not len(new) or rows["mode"][new[0]] != Mode.FOLLOW:
            continue
        rows = rows[new[0] :]
        moved = np.flatnonzero(np.hypot(*(rows["p_meas"] - rows["p_meas"][0]).T) > MOVED)
        if len(moved):
            found.append(1e-6 * (rows["t_ns"][moved[0]] - rows["t_ns"][0]))
    return found


def latencies(one: Stack) -> list[tuple[float, float, float]]:
    """Injected, with the camera's own; that with which frames really left, as the virtual rig has it; shown [ms]."""
    assert one.virtual is not None
    own, found = one.virtual.rig.twin.marker_latency, []
    for late in INJECTED:
        one.virtual.do(f"late {max(late, own) if late else 0}")
        time.sleep(4.0)
        left, shown = one.virtual.latency(), one.drivers()["motion_capture"]["latency"]
        found.append((1e3 * max(late, own), 1e3 * left, 1e3 * shown))
    one.virtual.do("mend")
    return found


def cost(one: Stack, seconds: float = 10.0) -> dict[str, tuple[float, float]]:
    """Resident memory [MB] and share of a core [%] of rig and server, vented, with one viewer."""
    processes = {"rig": psutil.Process(one.rig_process), "server": psutil.Process(one.server_process)}
    before = {name: sum(process.cpu_times()[:2]) for name, process in processes.items()}
    time.sleep(seconds)
    return {
        name: (process.memory_info().rss / 1e6, 100 * (sum(process.cpu_times()[:2]) - before[name]) / seconds)
        for name, process in processes.items()
    }


def measured(text: str, folder: Path, repeats: int) -> dict[str, Any]:
    """Everything of one kind of rig."""
    with stack(folder, text) as one:
        time.sleep(3.0)
        quiet = cost(one)
        one.arm()
        tasks = {task: [rmse(one, task) for _ in range(repeats)] for task in TASKS}
        time.sleep(2.0)
        drags = drag_ms(one)
        row = find_ring(one.name).newest()
        assert row is not None
        found = {
            "cost": quiet,
            "tasks": tasks,
            "drag": drags,
            "lost per minute": 60e3 * row["lost"] / (row["slot"] + 1),
            "mode": Mode(row["mode"]).name,
        }
        if one.virtual is not None:
            found["latency"] = latencies(one)
            found["drivers"] = {
                role: {name: each[name] for name in ("rate", "frames", "lost", "rejected")}
                for role, each in one.drivers().items()
            }
    return found


def main() -> None:
    """Twin first, then each pair of wires."""
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    rigs = {"twin": "", "NatNet + serial": SERIAL, "NatNet + Modbus": MODBUS}
    with tempfile.TemporaryDirectory(prefix="tendril-virtual-") as place:
        found = {name: measured(text, Path(place, str(i)), repeats) for i, (name, text) in enumerate(rigs.items())}
    for name, one in found.items():
        print(f"\n{name}: {one['mode']}, {one['lost per minute']:.0f} ticks lost a minute")
        for role, (memory, share) in one["cost"].items():
            print(f"  {role:7} {memory:6.0f} MB {share:6.1f} % of a core, vented, one viewer")
        for task, each in one["tasks"].items():
            mine, twins = np.median(each), np.median(found["twin"]["tasks"][task])
            print(f"  {task:18} RMSE {mine:6.2f} mm, {mine / twins:5.2f} of the twin's")
        print(f"  from target to motion {np.median(one['drag']):.1f} ms (median of {len(one['drag'])})")
        for injected, left, shown in one.get("latency", ()):
            print(f"  latency injected {injected:5.1f} ms, left with {left:5.1f}, shown {shown:5.1f}")
        for role, each in one.get("drivers", {}).items():
            print(f"  {role}: {each}")


if __name__ == "__main__":
    main()
