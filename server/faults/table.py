"""The faults of the campaign as data: `tendril faults` runs this table, and docs/faults.md shows it."""

from pathlib import Path
from typing import NamedTuple

from controller.errors import ParameterError

PAGE = Path("docs/faults.md")
GAP = 0.15
"""The campaign's rigs hold after their loop stood still for so long [s]; shared machines pause for 50 ms and more."""


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

FAULTS = (
    Fault("server-killed", "kill -9 of the server", "HOLD; the next server finds it held and can go on", HOLD_MS, True),
    Fault("server-stopped", "SIGSTOP of the server, SIGCONT after 2 s", "HOLD, also on resume", HOLD_MS),
    Fault(
        "server-gone", "kill -9 of the server, none after it", "HOLD after 0.5 s; REST after 30 s, then VENTED", 31e3
    ),
    Fault("rig-killed", "kill -9 of the rig", "restarted VENTED; the page says so", RESTART_MS, True),
    Fault("rig-paused", "SIGSTOP of the rig, SIGCONT after 250 ms", "HOLD (loop stalled) on resume", 100.0),
    Fault("rig-stopped", "SIGSTOP of the rig for good", "killed, restarted VENTED; the page says so", RESTART_MS),
    Fault(
        "recorder-killed",
        "kill -9 of the server, of which the recorder is a thread, while it records",
        "HOLD; the next server mends the recording and goes on in a second part without a hole",
        HOLD_MS,
    ),
    Fault(
        "recorder-stopped",
        "SIGSTOP of the server while it records, SIGCONT after 2 s",
        "HOLD; no tick is missing in the recording",
        HOLD_MS,
    ),
    Fault(
        "disk-full",
        "RLIMIT_FSIZE of the server lowered to 300 kB above its recording",
        "the recording ends, log and page say why; the rig goes on tracking",
        10_000.0,
        True,
    ),
    Fault("clock-forward", "wall clock of rig and server +1 h (time.time)", "nothing; E-STOP works", 1e3 * GAP),
    Fault("clock-back", "wall clock of rig and server -1 h (time.time)", "nothing; E-STOP works", 1e3 * GAP),
    Fault("page-closed", "the operator's socket is closed in the middle of a drag", "HOLD", HOLD_MS, True),
    Fault("browser-killed", "kill -9 of the operator's chromium in the middle of a drag", "HOLD", HOLD_MS),
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
)


def chosen(only: str | None, quick: bool) -> list[Fault]:
    """The faults of a campaign, in the table's order; ParameterError for a name that it does not have."""
    names = {fault.name for fault in FAULTS}
    wanted = {name.strip() for name in only.split(",")} if only else names
    if unknown := sorted(wanted - names):
        raise ParameterError(f"fault = {unknown[0]!r} is not one of {', '.join(fault.name for fault in FAULTS)}")
    return [fault for fault in FAULTS if fault.name in wanted and (fault.quick or not quick)]


def markdown() -> str:
    """The table of docs/faults.md."""
    head = "| fault | injected | expected | limit |\n|---|---|---|---|\n"
    rows = (f"| `{f.name}` | {f.injected} | {f.expected} | {_limit(f.limit_ms)} |\n" for f in FAULTS)
    return head + "".join(rows)


def filled(page: str) -> str:
    """`page` with today's table between its marks."""
    before, rest = page.split("<!-- faults -->\n")
    after = rest.split("<!-- /faults -->")[1]
    return f"{before}<!-- faults -->\n{markdown()}<!-- /faults -->{after}"


def _limit(ms: float) -> str:
    return f"{ms:g} ms" if ms < 10_000 else f"{ms / 1e3:g} s"


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text()))
