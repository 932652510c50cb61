"""`tendril faults`: one fault after the other, each from a fresh motion, and a verdict for each."""

import signal
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypedDict

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from controller.errors import TendrilError
from controller.schema.modes import Cause
from controller.system.progress import progress
from server.campaign import processes
from server.campaign.rows import (
    abuse,
    choices,
    files,
    inner,
    lease,
    link,
    load,
    page,
    people,
    plant,
    sensing,
    stops,
    strangers,
    wires,
)
from server.campaign.scene import Kind, Scene
from server.campaign.table import OVER_TLS, Fault
from server.campaign.waiting import NotTried, Seen, Skipped

ACTS: dict[str, Callable[[Scene], Seen]] = {
    "server-killed": processes.server_killed,
    "server-stopped": processes.server_stopped,
    "server-gone": processes.server_gone,
    "rig-killed": processes.rig_killed,
    "rig-killed-stopped": processes.rig_killed_stopped,
    "rig-paused": processes.rig_paused,
    "rig-stopped": processes.rig_stopped,
    "planner-killed": processes.planner_killed,
    "recorder-killed": files.recorder_killed,
    "writer-killed": files.writer_killed,
    "recorder-stopped": files.recorder_stopped,
    "disk-full": files.disk_full,
    "disk-hung": inner.disk_hung,
    "beat-failing": inner.beat_failing,
    "thread-dead": inner.thread_dead,
    "loop-stuck": inner.loop_stuck,
    "loop-stuck-stop": inner.loop_stuck_stop,
    "loop-dead": inner.loop_dead,
    "supervisor-oserror": inner.supervisor_oserror,
    "token-unreadable": inner.token_unreadable,
    "clock-forward": files.clock_forward,
    "clock-back": files.clock_back,
    "page-closed": people.page_closed,
    "browser-killed": page.killed,
    "page-busy": page.busy,
    "page-hung": page.hung,
    "page-painter": page.painter,
    "page-two-sign-ins": page.two_sign_ins,
    "laptop-asleep": people.laptop_asleep,
    "two-operators": people.two_operators,
    "lease-lost-planning": lease.lost_planning,
    "control-lost": page.control_lost,
    "cpu-hog": load.cpu_hog,
    "gil-hog": load.gil_hog,
    "pump-dead": load.pump_dead,
    "malformed": abuse.malformed,
    "estop-flood": stops.under_flood,
    "mocap-20ms": sensing.dropout_short,
    "mocap-200ms": sensing.dropout_long,
    "mocap-5s": sensing.lost,
    "mocap-nan": sensing.nan,
    "mocap-old": sensing.old,
    "mocap-frozen": sensing.frozen,
    "mocap-jump": sensing.jump,
    "sensor-stuck": plant.sensor_stuck,
    "valve-stuck": plant.valve_stuck,
    "supply-lost": plant.supply_lost,
    "serial-cut": wires.serial_cut,
    "board-reset": wires.board_reset,
    "board-hung": wires.board_hung,
    "half-frame": wires.half_frame,
    "answers-late": wires.answers_late,
    "natnet-stopped": wires.camera_stopped,
    "markers-swapped": wires.markers_swapped,
    "markers-ghosts": wires.ghosts,
    "modbus-timeout": wires.modbus_timeout,
    "udp-silent": wires.udp_silent,
    "markers-unnamed-swap": wires.unnamed_swapped,
    "uncommissioned": wires.uncommissioned,
    "gains-hard": choices.gains_hard,
    "actuator-unbuildable": choices.actuator_unbuildable,
    "link-cut": link.cut,
    "link-silent": link.silent,
    "link-delayed": link.delayed,
    "link-lossy": link.lossy,
}
STRANGERS: dict[str, Callable[[Scene], Seen]] = {
    "stranger-forged-row": strangers.forged_row,
    "stranger-command-key": strangers.command_key,
    "stranger-silent-queryable": strangers.silent_queryable,
    "stranger-flood": strangers.flood,
    "stranger-replayed": strangers.replayed,
}
ACTS |= STRANGERS | {f"{name}{OVER_TLS}": act for name, act in STRANGERS.items()}
AT_OWN_RATES = ("estop-flood",)
"""Faults of a server with its own limits of how often it may be asked."""
ATTEMPTS_MAX = 3
"""So often a fault is tried when the machine itself stood still meanwhile, or the rig was not ready for it."""
NOT_TRIED = "not tried"
TOLD = 12
"""Lines of the page's log that are shown where a fault was not survived."""

Verdict = TypedDict(
    "Verdict",
    {
        "name": str,
        "expected": str,
        "observed": str,
        "reaction_ms": float | None,
        "limit_ms": float,
        "pass": bool,
    },
)


class Campaign:
    """Keeps a scene from one fault to the next while the faults pass, and makes a new one after one that did not."""

    def __init__(self, out: Console, folder: Path) -> None:
        self._out, self._folder = out, folder
        self._scene: Scene | None = None
        self._scenes = 0

    def run(self, faults: Sequence[Fault]) -> list[Verdict]:
        """A verdict for every fault that can be injected here."""
        verdicts = []
        try:
            with progress(self._out, "") as bar:
                for done, fault in enumerate(faults, 1):
                    bar.name(f"{fault.name}: {fault.injected} ...")
                    verdict = self._judge(fault)
                    bar(done / len(faults))
                    if verdict is None:
                        continue
                    verdicts.append(verdict)
                    self._out.print(f"{_mark(verdict)} {fault.name}: {escape(verdict['observed'])}", highlight=False)
        finally:
            self._leave()
        return verdicts

    def _judge(self, fault: Fault) -> Verdict | None:
        """None where it cannot be injected here. What says nothing of the fault is tried again."""
        words = ""
        for _ in range(ATTEMPTS_MAX):
            start = time.monotonic_ns()
            try:
                seen = ACTS[fault.name](self._at(fault))
                return _verdict(fault, seen.observed, seen.reaction_ms)
            except Skipped as error:
                self._out.print(f"[yellow]skipped[/] {fault.name}: {escape(str(error))}")
                return None
            except Exception as error:  # the next fault is judged whatever became of this one
                words, untried = _words(error), isinstance(error, NotTried) or self._machine_stood_still(start)
                self._show_log()
                self._leave()
                if not untried:
                    return _verdict(fault, words, None)
        return _verdict(fault, f"{NOT_TRIED}: {words}", None)

    def _at(self, fault: Fault) -> Scene:
        """A scene that fits: with a proxy in the link, a link over TLS, or the devices of a virtual rig."""
        kind = Kind(
            proxied=fault.name.startswith("link-"),
            encrypted=fault.name.endswith(OVER_TLS),
            rate_factor=1.0 if fault.name in AT_OWN_RATES else 100.0,  # an abuser who is told to wait would ask less
            wires=wires.RIGS.get(fault.name, ""),
        )
        if self._scene is None or self._scene.kind != kind:
            self._leave()
            self._scenes += 1
            self._scene = Scene(self._folder / str(self._scenes), kind)
        return self._scene

    def _machine_stood_still(self, start: int) -> bool:
        """Whether a loop stalled meanwhile that no fault had stopped: then nothing can be said."""
        try:
            return self._scene is None or bool((self._scene.since(start)["cause"] == Cause.LOOP_STALLED).any())
        except TendrilError:
            return False

    def _show_log(self) -> None:
        """What the page was told last: it often says why a fault was not survived."""
        for line in self._scene.operator.log[-TOLD:] if self._scene else ():
            self._out.print(f"  log: {line}", highlight=False, markup=False)

    def _leave(self) -> None:
        scene, self._scene = self._scene, None
        if scene is not None:
            scene.close()


def run_campaign(faults: Sequence[Fault], repeat: int, out: Console) -> list[Verdict]:
    """All faults, `repeat` times, each time with a table."""
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell may have started us in the background, SIGINT ignored
        signal.signal(number, signal.default_int_handler)
    verdicts: list[Verdict] = []
    with tempfile.TemporaryDirectory(prefix="tendril-faults-") as folder:
        for turn in range(1, repeat + 1):
            place = Path(folder, str(turn))
            place.mkdir()
            found = Campaign(out, place).run(faults)
            out.print(_table(found))
            verdicts += found
    return verdicts


def _words(error: Exception) -> str:
    return str(error) if isinstance(error, TendrilError) else f"{type(error).__name__}: {error}"


def _verdict(fault: Fault, observed: str, reaction_ms: float | None) -> Verdict:
    took = None if reaction_ms is None else round(float(reaction_ms), 1)
    return {
        "name": fault.name,
        "expected": fault.expected,
        "observed": observed,
        "reaction_ms": took,
        "limit_ms": fault.limit_ms,
        "pass": took is not None and took <= fault.limit_ms,
    }


def _table(verdicts: list[Verdict]) -> Table:
    table = Table("fault", "expected", "observed", "ms", "limit", "", title="tendril faults", title_justify="left")
    for one in verdicts:
        took = "-" if one["reaction_ms"] is None else f"{one['reaction_ms']:.0f}"
        words = one["name"], escape(one["expected"]), escape(one["observed"])
        table.add_row(*words, took, f"{one['limit_ms']:.0f}", _mark(one))
    return table


def _mark(one: Verdict) -> str:
    if one["pass"]:
        return "[green]pass[/]"
    return "[yellow]----[/]" if one["observed"].startswith(NOT_TRIED) else "[red]FAIL[/]"
