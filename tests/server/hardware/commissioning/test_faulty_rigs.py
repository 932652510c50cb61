"""A rig file with one fault of each kind is commissioned: the step that can find it does, and the arm hardly moves.

The steps themselves, on the twin in virtual time, behind the chambers, camera and names of a true rig file.
"""

import asyncio
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
import pytest

from controller.schema.commissioned import GATE, StepName
from controller.schema.hardware import Drivers, DriverStatus
from controller.schema.modes import Law, Request
from controller.schema.parameters import RigParameters, Settings, TwinParameters
from controller.schema.rig_file import RigFile, parse_rig_file
from controller.virtual.rig import seen_by_camera
from server.access.permit import own
from server.hardware.commissioning import drivers, signs
from server.hardware.commissioning.frame import Framing
from server.hardware.commissioning.jog import Jogging
from server.hardware.commissioning.messages import CHAMBERS, CaptureBody, StartBody
from server.hardware.commissioning.step_run import StepContext, StepRun
from server.hardware.commissioning.store import CommissioningStore, Found
from server.rig.history import History
from tests.controller.trial import Trial, true_tip
from tests.server.commissioning_bench import driver_status
from tests.server.virtual_time import VirtualLoop

T = TypeVar("T")
TICKS = 10
"""Rows that come at once."""
MOVED_MAX = 0.03
"""No fault is found by a tip that goes further off its rest than this [m]."""
TRUE = """
name = "bench"
[motion_capture]
driver = "natnet"
rods = [3, 6, 10]
labels = { three = 3, six = 6, tip = 10 }
[motion_capture.frame]
axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
origin = [0.1, -0.2]
[valves]
driver = "serial"
chambers = [2, 3, 0, 1]
"""
LIVELY = {"zeta": 0.1, "inflate_time": 0.03, "exhaust_time": 0.03}
"""An arm that hardly damps, behind fast valves: it overshoots most."""


class Bench:
    """The twin behind the devices of the rig file `true`, as the rig file `file` shows them."""

    def __init__(self, true: RigFile, file: RigFile, twin: dict[str, Any]) -> None:
        self.true, self.file = true, file
        self.parameters = RigParameters(twin=TwinParameters(**twin))
        self.trial = Trial(parameters=self.parameters, law=Law.OPEN_LOOP, u_open=(0.0, 0.0), sensed=0)
        self.trial.arm()
        rows = self.trial.ask(Request.FOLLOW, (0.2, 0.0), 1000)
        self.rest, self.moved = true_tip(rows)[-1], 0.0
        self.moved_after, self.pairs = dict[StepName, float](), list[Any]()
        self.random = np.random.default_rng(1)
        self.pressures, self.markers = np.zeros(4), rows["markers"][-1].copy()
        self.history, self.touched, self.lost = History(60_000, 100), False, ""
        self.paused, self.info, self.operator = False, None, SimpleNamespace(settings=Settings())

    @property
    def newest(self) -> Any:
        return self.history.newest

    def boot(self) -> int:
        return 1

    def require_info(self) -> Any:
        return SimpleNamespace(boot=1, parameters=self.parameters)

    def torque(self, u: tuple[float, float]) -> None:
        """What the rig asks of its channels fills what hangs there."""
        full = self.parameters.actuator.pressure_map
        asked = [max(0.0, side * u[pair] * full[pair]) for pair in (0, 1) for side in (1.0, -1.0)]
        filled = np.zeros(4)
        filled[self._true_chambers()] = asked
        self.trial.switch(u_open=((filled[0] - filled[1]) / full[0], (filled[2] - filled[3]) / full[1]))

    async def run(self) -> None:
        """Row after row, in virtual time."""
        while True:
            rows = self.trial.run(TICKS)
            ways = np.linalg.norm(true_tip(rows) - self.rest, axis=1)
            self.moved = max(self.moved, float(ways.max()))
            self.pressures = rows["pressure_meas"][-1].copy()
            seen = rows["markers"][-1]
            self.markers = np.where(np.isfinite(seen), seen, self.markers)
            shown = rows.copy()
            shown["p_meas"] = self._in_plane(rows["p_meas"])
            shown["pressure_meas"] = rows["pressure_meas"][:, self._true_chambers()]
            self.history.add(shown)
            await asyncio.sleep(1e-3 * TICKS)

    def drivers(self) -> Drivers:
        """The devices as the page shows them."""
        labels = self.true.motion_capture.labels
        places = {name: self.markers[rod - 1] for name, rod in labels.items()}
        if self.touched:
            places["wand"] = self.random.normal(0.0, 1e-4, 2)
        camera = self.true.motion_capture.frame
        values = {name: seen_by_camera(at[None], camera)[0].tolist() for name, at in places.items()}
        board = {"pressures": self.pressures.tolist()}
        return Drivers(drivers=(self._status("motion_capture", values), self._status("valves", board)))

    def _status(self, role: str, values: dict[str, Any]) -> DriverStatus:
        found = driver_status(role, values)
        gone = self.lost and role == "valves"
        return found.model_copy(update={"state": "lost", "detail": self.lost}) if gone else found

    def _in_plane(self, places: np.ndarray) -> np.ndarray:
        """Places (n,2) [m] as the frame of the rig's own file has them."""
        frame = self.file.motion_capture.frame
        seen = seen_by_camera(places.astype(float), self.true.motion_capture.frame)
        return np.asarray(seen @ np.array(frame.axes).T + np.array(frame.origin))

    def _true_chambers(self) -> list[int]:
        """Chambers that really hang where the rig's own file has u1+, u1-, u2+, u2-."""
        return [self.true.valves.chambers.index(channel) for channel in self.file.valves.chambers]


class BenchRun(StepRun):
    """Asks a bench in place of a rig."""

    bench: Bench

    async def take_rig(self, **settings: Any) -> None:
        pass

    async def torque(self, u: tuple[float, float]) -> None:
        self.bench.torque(u)

    async def give_back(self) -> None:
        self.bench.torque((0.0, 0.0))
        await asyncio.sleep(2.0)


class Planner:
    """At once, here."""

    async def do(self, work: Callable[..., T], *arguments: Any) -> T:
        return work(*arguments)


def step_run(step: StepName, bench: Bench, store: CommissioningStore | None = None) -> StepRun:
    events = SimpleNamespace(add=lambda *told: None)
    context = SimpleNamespace(
        rig=bench, history=bench.history, operator=bench.operator, kept=None, note=None, events=events
    )
    procedures = SimpleNamespace(context=context)
    parts = SimpleNamespace(procedures=procedures, planner=Planner(), drivers=bench.drivers, store=store)
    run = BenchRun(step, StartBody(), own(), bench.file, Path(), cast(StepContext, parts))
    run.bench = bench
    return run


async def jogged(run: StepRun, bench: Bench) -> Found:
    """An operator holds each button, and says which chamber they saw fill."""
    jogging = Jogging(asyncio.get_running_loop().time)
    step = asyncio.get_running_loop().create_task(jogging.do(run))
    await asyncio.sleep(0.5)
    for chamber in CHAMBERS:
        while not any(one.commanded == chamber for one in jogging.view().jogged):
            jogging.hold(chamber)
            await asyncio.sleep(0.1)
        seen = CHAMBERS[int(np.argmax(bench.pressures))]
        jogging.hold(None)
        jogging.confirm(chamber, seen)
        await asyncio.sleep(1.5)
    return await step


async def framed(run: StepRun, bench: Bench) -> Found:
    """They touch the base, and capture the marker that sits at the tip."""
    framing = Framing()
    step = asyncio.get_running_loop().create_task(framing.do(run))
    for place, point in (("base", "wand"), ("tip", "tip"), ("bent", "tip")):
        bench.touched = place == "base"
        await framing.capture(CaptureBody(place=place, point=point), run)  # type: ignore[arg-type]
        await asyncio.sleep(0.1)
        if step.done():
            break
    return await step


async def done(step: StepName, run: StepRun, bench: Bench) -> Found:
    match step:
        case "drivers":
            return await drivers.do(run)
        case "jog":
            return await jogged(run, bench)
        case "frame":
            return await framed(run, bench)
        case _:
            return await signs.do(run)


def commissioned(bench: Bench, steps: tuple[StepName, ...] = GATE) -> dict[StepName, Found]:
    """What came of each step, accepted where it is good, up to the first that is not."""
    loop, found = VirtualLoop(), dict[StepName, Found]()
    rows = loop.create_task(bench.run())
    try:
        loop.run_until_complete(asyncio.sleep(1.0))
        for step in steps:
            run = step_run(step, bench)
            one = loop.run_until_complete(done(step, run, bench))
            found[step], bench.moved_after[step] = one, bench.moved
            bench.pairs += run.pairs
            print(f"{step}: {one.text} (tip {bench.moved * 1e3:.1f} mm off its rest at most)")
            if not one.good:
                break
            bench.file = with_lines(bench.file, one.changes)
            loop.run_until_complete(asyncio.sleep(3.0))
    finally:
        rows.cancel()
        loop.run_until_complete(asyncio.sleep(0.1))
        loop.close()
    return found


def with_lines(file: RigFile, changes: dict[str, Any]) -> RigFile:
    values = file.model_dump(mode="json")
    for field, value in changes.items():
        *tables, name = field.split(".")
        at = values
        for table in tables:
            at = at[table]
        at[name] = value
    return RigFile.model_validate(values)


class Fault(NamedTuple):
    """What the rig file says otherwise, and how it is found."""

    changes: dict[str, Any]
    step: StepName
    words: str
    mended: bool
    """By what the step writes; else the operator is told and no step goes on."""
    camera: dict[str, Any] = {}  # noqa: RUF012  never changed
    """What is otherwise at the devices themselves."""


FAULTS = {
    "two chambers swapped": Fault(
        {"valves.chambers": [2, 3, 1, 0]}, "jog", "hang at channels 2, 3, 0, 1, not at 2, 3, 1, 0", mended=True
    ),
    "chambers of two pairs swapped": Fault(
        {"valves.chambers": [0, 3, 2, 1]}, "jog", "hang at channels 2, 3, 0, 1, not at 0, 3, 2, 1", mended=True
    ),
    "one frame axis mirrored": Fault(
        {"motion_capture.frame.axes": [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]},
        "frame",
        "y of the rig file was mirrored",
        mended=True,
    ),
    "two labels swapped": Fault(
        {"motion_capture.labels": {"three": 3, "six": 10, "tip": 6}},
        "frame",
        "labels six and tip are swapped: six lies at rod 6, tip lies at rod 10",
        mended=False,
    ),
    "wrong unit": Fault(
        {},
        "frame",
        "does the camera measure in mm? Set its driver's unit",
        mended=False,
        camera={"motion_capture.frame.axes": [[0.0, 0.0, 1e-3], [1e-3, 0.0, 0.0]]},
    ),
    "wrong port": Fault(
        {"valves.options": {"port": "/dev/ttyNONE"}}, "drivers", "is lost: no such port /dev/ttyNONE", mended=False
    ),
    "camera upside down": Fault(
        {"motion_capture.frame.axes": [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]]},
        "frame",
        "the rig file had the camera upside down",
        mended=True,
    ),
}


def bench_with(changes: dict[str, Any], camera: dict[str, Any] | None = None, **twin: Any) -> Bench:
    right = parse_rig_file(TRUE, "the rig")
    return Bench(with_lines(right, camera or {}), with_lines(right, changes), twin)


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_of_a_rig_file_is_found_at_the_step_that_can_and_the_arm_hardly_moves(name: str) -> None:
    fault = FAULTS[name]
    bench = bench_with(fault.changes, fault.camera, **LIVELY)
    if "valves.options" in fault.changes:
        bench.lost = f"no such port {fault.changes['valves.options']['port']}"
    found = commissioned(bench)
    assert [step for step, one in found.items() if fault.words in one.text] == [fault.step]
    assert list(found) == list(GATE if fault.mended else GATE[: GATE.index(fault.step) + 1])
    assert [step for step, one in found.items() if not one.good] == ([] if fault.mended else [fault.step])
    assert bench.moved < MOVED_MAX
    if fault.step == "frame" and not fault.mended:
        assert bench.moved_after["frame"] == bench.moved_after["jog"], "nothing moves for what base and tip show"


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"valves.chambers": [2, 3, 1, 0]}, "two chambers are exchanged, and these ways do not tell which"),
        ({"valves.chambers": [3, 2, 0, 1]}, "two chambers are exchanged, and these ways do not tell which"),
        ({"valves.chambers": [0, 3, 2, 1]}, "u1+ and u2+ are exchanged, or this is another actuator"),
    ],
    ids=["u2", "u1", "u1+ and u2+"],
)
def test_chambers_that_were_confirmed_wrongly_are_found_by_their_signs(changes: dict[str, Any], words: str) -> None:
    """As an operator leaves it who mistook them: the frame is measured with the wrong chamber, too."""
    bench = bench_with(changes)
    found = commissioned(bench, ("frame", "signs"))
    assert found["frame"].good and not found["signs"].good
    assert words in found["signs"].text and bench.moved < MOVED_MAX


def test_a_mirrored_frame_that_no_step_has_measured_is_found_by_both_signs() -> None:
    frame = {"axes": [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]], "origin": [0.1, 0.2], "measured": True}
    bench = bench_with({"motion_capture.frame": frame})
    found = commissioned(bench, ("signs",))
    assert "y of the frame is mirrored, or two chambers of each pair are exchanged" in found["signs"].text
    assert bench.moved < MOVED_MAX


def test_a_rig_file_without_a_fault_goes_through_and_every_pair_is_kept() -> None:
    bench = bench_with({})
    found = commissioned(bench)
    assert [step for step, one in found.items() if one.good] == list(GATE)
    assert found["jog"].changes == {}
    filled = [f"{chamber} filled, pressures" for chamber in CHAMBERS]
    pushed = [f"{what}, {chamber} filled" for chamber in ("u1+", "u2+") for what in ("tip", "pressures")]
    assert [one["what"] for one in bench.pairs] == [*filled, "tip, u1+ filled, as the camera sees it", *pushed]
    for one in bench.pairs:
        way = np.linalg.norm(np.array(one["after"]) - np.array(one["before"]))
        assert way > (2e3 if one["unit"] == "Pa" else 0.012)


async def test_pairs_of_a_step_that_ended_early_are_kept_with_its_result(tmp_path: Path) -> None:
    store = CommissioningStore(tmp_path / "kept.json")
    run = step_run("signs", bench_with({}), store)
    run.keep_pair("tip, u1+ filled", np.array([0.25, np.nan]), np.array([0.24, 0.01]), "m")
    await run.finish()
    kept = CommissioningStore(tmp_path / "kept.json").kept.results["signs"]
    pair = {"what": "tip, u1+ filled", "before": [0.25, None], "after": [0.24, 0.01], "unit": "m"}
    assert not kept.good and kept.data == {"pairs": [pair]}
