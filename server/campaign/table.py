"""The faults of the campaign as data: `tendril faults` runs this table, and docs/faults.md shows it."""

from pathlib import Path
from typing import NamedTuple

from controller.errors import ParameterError
from controller.text.markdown import filled, table

PAGE = Path("docs/faults.md")
GAP = 0.15
"""The campaign's rigs hold after their loop stood still for so long [s]; shared machines pause for 50 ms and more."""

BOARD_GAP = 0.3
"""The same without pressures: such a pause is the loop's own only beyond GAP. Elsewhere it is 0.1 s (safety.md)."""


class Fault(NamedTuple):
    """One fault, and what has to come of it."""

    name: str
    injected: str
    expected: str
    limit_ms: float
    """Longest time to the reaction; where nothing may happen, longest time for which the loop may stand still."""
    quick: bool = False
    """Part of the shortened campaign."""


HOLD_MS = 600.0
"""The rig holds 500 ms after the last sign; the rest is for signs that came just before the fault."""
RESTART_MS = 15_000.0
"""For a new process, whose imports a busy machine slows down."""

LOST_MS = 20_000.0
"""Until control that was lost is said: a page that stands still says it when it goes on, a new server begins first."""

OVER_TLS = "-tls"
"""Ends the name of a fault whose link is encrypted."""
STOP_MS = 500.0
"""From an operator's E-STOP to the rig's, on a machine that attacks itself meanwhile."""
NOTHING = "nothing: FOLLOW goes on, the page is true, no tick is missing in the recording; an E-STOP works"

STRANGERS = (
    Fault(
        "stranger-forged-row",
        "telemetry with the real boot id, a minute ahead, by strangers in every mode of zenoh",
        NOTHING,
        STOP_MS,
        True,
    ),
    Fault("stranger-command-key", "they answer on the rig's keys that everything is refused", NOTHING, STOP_MS),
    Fault("stranger-silent-queryable", "they take the rig's keys and never answer", NOTHING, STOP_MS),
    Fault(
        "stranger-flood",
        "thousands of puts, deletes and questions a second, and 200 connections that say nothing",
        NOTHING,
        STOP_MS,
    ),
    Fault(
        "stranger-replayed",
        "sealed messages of a server with the key, E-STOP among them, once more and as they were",
        NOTHING,
        STOP_MS,
    ),
)

BOARD_MS = 1e3 * BOARD_GAP + 200.0
"""Without pressures for BOARD_GAP, and what came just before."""
CAMERA_MS = 700.0
"""500 ms without a usable marker, the same."""

FAULTS = (
    Fault("server-killed", "kill -9 of the server", "HOLD; the next server finds it held and can go on", HOLD_MS, True),
    Fault("server-stopped", "SIGSTOP of the server, SIGCONT after 2 s", "HOLD, also on resume", HOLD_MS),
    Fault(
        "server-gone", "kill -9 of the server, none after it", "HOLD after 0.5 s; REST after 30 s, then VENTED", 31e3
    ),
    Fault("rig-killed", "kill -9 of the rig", "restarted VENTED; the page says so", RESTART_MS, True),
    Fault(
        "rig-killed-stopped", "E-STOP, then kill -9 of the rig", "restarted in E-STOP; only CLEAR ends it", RESTART_MS
    ),
    Fault("rig-paused", "SIGSTOP of the rig, SIGCONT after 250 ms", "HOLD (loop stalled) on resume", 100.0),
    Fault("rig-stopped", "SIGSTOP of the rig for good", "killed, restarted VENTED; the page says so", RESTART_MS),
    Fault(
        "planner-killed",
        "kill -9 of the process that plans, while it foresees a run",
        "TRACK goes on; another one foresees the run",
        1e3 * GAP,
    ),
    Fault(
        "recorder-killed",
        "kill -9 of the server while it records",
        "HOLD; the recording goes on, and the next server ends it whole",
        HOLD_MS,
    ),
    Fault(
        "writer-killed",
        "kill -9 of the process that writes the recording",
        "TRACK goes on; the recording goes on in a second part without a hole, and the first is mended",
        1e3 * GAP,
    ),
    Fault(
        "recorder-stopped",
        "SIGSTOP of the server while it records, SIGCONT after 2 s",
        "HOLD; no tick is missing in the recording",
        HOLD_MS,
    ),
    Fault(
        "disk-full",
        "RLIMIT_FSIZE of the process that writes lowered to 300 kB above its recording",
        "the recording ends, log and page say why; the rig goes on tracking",
        10_000.0,
        True,
    ),
    Fault(
        "disk-hung",
        "recording and log files take nothing for 8 s",
        "log and page say so; the rig goes on tracking, an E-STOP works; the recording catches up, no tick is missing",
        4500.0,
    ),
    Fault(
        "beat-failing",
        "a job of the server's event loop raises OSError each time for 3 s",
        "one line in the log; frames, status and the rig go on, an E-STOP works",
        2500.0,
    ),
    Fault(
        "thread-dead",
        "SystemExit in the server's thread that commands the rig",
        "it begins again, the page says so; TRACK or HOLD, an E-STOP works",
        2500.0,
    ),
    Fault("loop-stuck", "the server's event loop stands still for 2 s", "HOLD; the page says so", HOLD_MS),
    Fault(
        "loop-stuck-stop",
        "the server's event loop stands still for 5 s, and the operator presses E-STOP",
        "E-STOP, answered while it still stands",
        STOP_MS,
    ),
    Fault(
        "loop-dead",
        "the server's event loop stands still for good",
        "HOLD; after 10 s the process is ended, another one serves",
        20_000.0,
    ),
    Fault(
        "supervisor-oserror",
        "kill -9 of the rig while the system refuses the supervisor another one for 2 s (OSError)",
        "tried again, restarted VENTED; the page says so",
        RESTART_MS,
    ),
    Fault(
        "token-unreadable",
        "the operator's token is renewed, and its file refused at the first looks",
        "HOLD as soon as it can be read; the revoked session has ended",
        2500.0,
    ),
    Fault("clock-forward", "wall clock of rig and server +1 h (time.time)", "nothing; E-STOP works", 1e3 * GAP),
    Fault("clock-back", "wall clock of rig and server -1 h (time.time)", "nothing; E-STOP works", 1e3 * GAP),
    Fault("page-closed", "the operator's socket is closed in the middle of a drag", "HOLD", HOLD_MS, True),
    Fault("browser-killed", "kill -9 of the operator's chromium in the middle of a drag", "HOLD", HOLD_MS),
    Fault("page-busy", "the main thread of the operator's chromium is busy for 2 s", "FOLLOW goes on", 1e3 * GAP),
    Fault("page-hung", "the same for 12 s", "HOLD meanwhile; nothing moves when it comes back", 4000.0),
    Fault(
        "page-painter",
        "a painter of the operator's plan throws at every frame",
        "marked on the page; drag, numbers and the other painters go on; drawn again once mended",
        3000.0,
    ),
    Fault(
        "page-two-sign-ins",
        "two tabs of one browser sign in three times each, at once",
        "one live socket for each tab, of one session; none is left",
        10_000.0,
    ),
    Fault(
        "laptop-asleep",
        "the operator's socket falls silent but stays open; wakes after 7 s",
        "HOLD; the lease is free after 5 s; waking moves nothing",
        HOLD_MS,
    ),
    Fault(
        "two-operators",
        "a second person asks for the lease, arms, drags and shows presence",
        "refused; the first goes on, and the second's presence keeps nothing moving",
        HOLD_MS,
        True,
    ),
    Fault(
        "lease-lost-planning",
        "control is lost to someone who is present, while a run is planned, uploaded or sent",
        "nothing moves; the run is refused by a sentence, its recording ended, none is under way",
        2000.0,
    ),
    Fault(
        "control-lost",
        "control of an operator who drags in chromium: the page hangs for 12 s, it is taken over, the server dies",
        "HOLD; the page says why and by whom, its log and the server's, too; nothing moves",
        LOST_MS,
    ),
    Fault("cpu-hog", "two busy processes for every core, 5 s", "TRACK or HOLD; the loop goes on", 1e3 * GAP),
    Fault("gil-hog", "the GIL of the rig held for 1 s, from its pump", "HOLD; the loop goes on", HOLD_MS),
    Fault("pump-dead", "the GIL of the rig held for 4 s, from its pump", "HOLD, REST after 2 s; vented", 2500.0),
    Fault(
        "malformed",
        "10 000 malformed requests, half of them on the live socket",
        "each refused by 4xx or by name; nothing restarts, the rig goes on",
        1e3 * GAP,
    ),
    Fault(
        "estop-flood",
        "E-STOPs under a mixed flood: all that a viewer may ask, messages, sign-ins and connections",
        "each in force, by socket, by HTTP and by both as the page presses; p99 of both to the rig's first row",
        40.0,
    ),
    Fault(
        "mocap-20ms",
        "no sample for 20 ms",
        "TRACK; feedback off only while samples are older than 50 ms, if at all",
        2.0,
    ),
    Fault(
        "mocap-200ms",
        "no sample for 200 ms",
        "TRACK; feedback off while samples are older than 50 ms, and then on",
        2.0,
    ),
    Fault("mocap-5s", "no sample for 5 s", "feedback off after 50 ms, FAULT after 500 ms, latched", 800.0),
    Fault("mocap-nan", "every marker is nan", "FAULT, latched", 800.0),
    Fault("mocap-old", "the last sample comes again and again, with its old time", "FAULT, latched", 800.0),
    Fault("mocap-frozen", "its positions come again and again, with fresh times", "FAULT, latched", 1500.0),
    Fault(
        "mocap-jump",
        "every marker is measured 50 mm beside where it is",
        "FAULT, latched",
        800.0,
    ),
    Fault("sensor-stuck", "the pressure sensor of chamber u1+ keeps its value", "E_STOP, latched", 3000.0),
    Fault("valve-stuck", "the spool of chamber u1+ stays where it is", "E_STOP, latched", 3000.0),
    Fault("supply-lost", "the supply line is open to the atmosphere", "E_STOP, latched", 3000.0),
    Fault(
        "serial-cut",
        "the cable of the valves' board is pulled, plugged in again after 2 s",
        "E-STOP (board lost), latched; the board vents by itself; nothing moves again without a fresh action",
        BOARD_MS,
        True,
    ),
    Fault(
        "board-reset",
        "the board's reset button",
        "E-STOP (board lost), latched: it drives nothing until it was vented",
        BOARD_MS,
    ),
    Fault("board-hung", "the board's program hangs for 2 s", "E-STOP (board lost), latched", BOARD_MS),
    Fault("half-frame", "half of one answer of the board", "TRACK goes on; it is counted", 1e3 * GAP),
    Fault(
        "answers-late",
        "the board's answers come 15 ms later for 2 s, after the driver's timeout of 10 ms",
        "TRACK goes on; they are used and counted, and the device's state says after how long they come",
        1e3 * GAP,
    ),
    Fault(
        "natnet-stopped",
        "the motion capture's stream ends, and begins again after 2 s",
        "FAULT (no measurement), latched",
        CAMERA_MS,
    ),
    Fault(
        "markers-swapped",
        "the camera gives tip and rod 6 each other's names",
        "FAULT (markers jumped), latched",
        CAMERA_MS,
    ),
    Fault("markers-ghosts", "eight ghosts in every frame for 2 s", "TRACK goes on, at the true tip", 1e3 * GAP),
    Fault(
        "modbus-timeout",
        "the valve terminal answers no more, and again after 2 s",
        "E-STOP (board lost), latched",
        BOARD_MS,
    ),
    Fault(
        "udp-silent",
        "the UDP target hears and answers no more, and again after 2 s",
        "E-STOP (board lost), latched; the target vents by itself; nothing moves again without a fresh action",
        BOARD_MS,
    ),
    Fault(
        "markers-unnamed-swap",
        "markers without names come in another order for 2 s",
        "TRACK goes on, at the true tip",
        1e3 * GAP,
    ),
    Fault(
        "uncommissioned",
        "devices of which no step of the commissioning is accepted are armed and run, also after kill -9 of the rig",
        "refused by the rig with what is missing; it stays vented",
        2000.0,
    ),
    Fault("gains-hard", "K_I = 20 1/s, the most that the page allows", "REST within 1 s of the whip, named", 1000.0),
    Fault(
        "actuator-unbuildable",
        "an actuator that gravity topples, so that nothing can be built with it: at the page, then past its check",
        "refused by name; past the check, the rig starts again with the one before, and the page says why",
        RESTART_MS,
    ),
    Fault("link-cut", "link between server and rig cut for 3 s", "HOLD; page: the rig is gone", HOLD_MS),
    Fault("link-silent", "link stalled for 3 s, nothing lost", "HOLD; old commands move nothing", HOLD_MS),
    Fault(
        "link-delayed",
        "300 ms of delay in each direction",
        "TRACK or HOLD; an E-STOP works",
        1500.0,
    ),
    Fault(
        "link-lossy",
        "20 % loss as TCP has it: such shares of the packets wait for 200 ms, 400 ms, ...",
        "TRACK or HOLD; an E-STOP works",
        5000.0,
    ),
    *STRANGERS,
    *(
        fault._replace(name=f"{fault.name}{OVER_TLS}", injected=f"{fault.injected}; over TLS", quick=False)
        for fault in STRANGERS
    ),
)


def chosen(only: str | None, quick: bool) -> list[Fault]:
    """The faults of a campaign, in the table's order; ParameterError for a name that it does not have, or for none."""
    names = {fault.name for fault in FAULTS}
    wanted = {name.strip() for name in only.split(",")} if only else names
    if unknown := sorted(wanted - names):
        raise ParameterError(f"fault = {unknown[0]!r} is not one of {', '.join(fault.name for fault in FAULTS)}")
    found = [fault for fault in FAULTS if fault.name in wanted and (fault.quick or not quick)]
    if not found:
        raise ParameterError(f"only = {only}: none of these is among the faults of --quick")
    return found


def markdown() -> str:
    """The table of docs/faults.md."""
    rows = ([f"`{f.name}`", f.injected, f.expected, _limit(f.limit_ms)] for f in FAULTS)
    return table(["fault", "injected", "expected", "limit"], rows)


def _limit(ms: float) -> str:
    return f"{ms:g} ms" if ms < 10_000 else f"{ms / 1e3:g} s"


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(), "faults", markdown()))
