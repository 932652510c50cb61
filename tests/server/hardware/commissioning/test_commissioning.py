"""The commissioning on a real rig and server: begun, ended by whatever happens, accepted, taken back."""

import re
import shutil
import time
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.schema.commissioned import marks
from controller.schema.hardware import Drivers
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters
from controller.schema.rig_file import changed, noted
from server.hardware.commissioning import pressure
from server.hardware.commissioning.messages import CHAMBERS, STEPS
from server.hardware.commissioning.store import KeptResult
from tests.server.commissioning_bench import Bench, bench_of, driver_status
from tests.server.hardware.commissioning.test_commissioning_steps import first_mode
from tests.server.hardware.commissioning.test_frame import camera
from tests.server.live_server import VIEWER_TOKEN, RigProcess, TestServer, taken, wait_for

pytestmark = pytest.mark.keyed("docs/examples")

EXAMPLES = Path(__file__).parents[4] / "docs" / "examples"


@pytest.fixture
def bench(shared_rig: RigProcess, tmp_path: Path) -> Iterator[Bench]:
    with bench_of(shared_rig.endpoint, tmp_path) as found:
        yield found


def test_a_fresh_rig_says_what_it_lacks_and_what_each_step_needs(bench: Bench) -> None:
    state = bench.state()
    assert [step["name"] for step in state["steps"]] == list(STEPS)
    assert {step["state"] for step in state["steps"]} == {"todo"}
    assert (state["available"], state["complete"], len(state["missing"])) == (True, False, len(STEPS))
    assert "frame assumed, not measured" in state["missing"]
    assert bench.step("drivers")["needs"] == []
    assert bench.step("frame")["needs"] == ["Chambers must be accepted first"]
    refused = bench.post("frame", "start")
    assert (refused.status_code, refused.json()["detail"]) == (409, "Chambers must be accepted first")
    assert bench.post("frame", "stop").json()["detail"] == "Frame is not under way"
    assert bench.post("frame", "accept").json()["detail"] == "Frame has no result to accept"
    jog = bench.page.put("/api/commissioning/jog", json={"chamber": "u1+"})
    assert (jog.status_code, jog.json()["detail"]) == (409, "Chambers is not under way: start it first")
    wide = bench.post("statics", "start", grid=20)
    assert wide.status_code == 422 and "less than or equal to 9" in wide.text
    viewer = bench.server.page().sign_in(VIEWER_TOKEN)
    assert viewer.get("/api/commissioning").json()["missing"] == state["missing"]
    assert viewer.post("/api/commissioning/drivers/start", json={}).status_code == 403
    bench.start("drivers")
    assert "the rig has no drivers: its plant is simulated" in bench.ended("drivers")["result"]
    bench.page.command("arm")
    bench.live.wait_mode(Mode.HOLD)
    assert bench.step("drivers")["needs"] == ["the rig is in HOLD, and must be vented to begin"]
    bench.page.command("rest")
    bench.live.wait_mode(Mode.VENTED)


def test_without_a_rig_file_it_is_not_available_and_says_how(server: TestServer) -> None:
    page = server.operator()
    state = page.get("/api/commissioning").json()
    assert not state["available"] and "tendril up --rig FILE.toml" in state["reason"]
    refused = page.post("/api/commissioning/drivers/start", json={})
    assert refused.status_code == 409 and "without a rig file" in refused.json()["detail"]


def hold(bench: Bench, chamber: str, seconds: float) -> np.ndarray:
    """Torques (n,2) [N m] that the page was shown while this button was held."""
    first, end = len(bench.live.frames), time.monotonic() + seconds
    while time.monotonic() < end:
        taken(bench.page.put("/api/commissioning/jog", json={"chamber": chamber}))
        time.sleep(0.1)
    return np.array([frame["u"] for frame in bench.live.frames[first:]])


def test_a_chamber_fills_only_while_its_button_is_held_and_what_filled_becomes_the_order_of_channels(
    bench: Bench,
) -> None:
    bench.accepted("drivers")
    bench.start("jog")
    bench.wait_doing("waits for a button")
    early = bench.page.put("/api/commissioning/jog/confirm", json={"commanded": "u1+", "filled": "u1+"})
    assert early.status_code == 409 and "u1+ was not jogged yet" in early.json()["detail"]
    swapped = {"u2+": "u2-", "u2-": "u2+"}
    for number, chamber in enumerate(CHAMBERS):

        def is_noted(chamber: str = chamber) -> bool:
            hold(bench, chamber, 0.3)
            return any(one["commanded"] == chamber for one in bench.state()["jog"]["jogged"])

        shown = hold(bench, chamber, 1.0)
        wait_for(is_noted, "a sensor that rises")
        at = shown[np.abs(shown).max(axis=1).argmax()]
        assert at[1 - number // 2] == 0.0 and at[number // 2] * (1 - 2 * (number % 2)) > 0.0
        assert np.abs(shown).max() * 4.0216e6 <= 0.45 * 30e3 + 1.0
        wait_for(lambda: not bench.live.frames[-1]["u"].any(), "zero by itself")  # no one renewed it
        confirmed = {"commanded": chamber, "filled": swapped.get(chamber, chamber)}
        taken(bench.page.put("/api/commissioning/jog/confirm", json=confirmed))
    found = bench.ended("jog")
    assert found["state"] == "done" and "0, 1, 3, 2, not at 0, 1, 2, 3" in found["result"]
    assert [(one["field"], one["before"], one["after"]) for one in found["writes"]] == [
        ("valves.chambers", [0, 1, 2, 3], [0, 1, 3, 2])
    ]
    assert [one["rose"] for one in bench.state()["jog"]["jogged"]] == list(CHAMBERS)
    bench.live.wait_mode(Mode.VENTED)
    assert bench.put_back()
    assert bench.rig().valves.chambers == (0, 1, 2, 3)  # nothing before it is accepted
    taken(bench.post("jog", "accept"))
    assert bench.rig().valves.chambers == (0, 1, 3, 2) and "jog" in bench.rig().commissioned
    assert "# at the left side" in bench.file.read_text()
    step = bench.step("jog")
    assert (step["accepted"], step["lacks"], step["by"]) == (True, "", found["by"])
    seen = {"commissioned.frame": "seen with the other order"}
    bench.file.write_text(changed(bench.file.read_text(), seen, bench.file.name))
    taken(bench.post("jog", "accept"))  # once more, and nothing changes by it
    assert "frame" in bench.rig().commissioned and not bench.step("frame")["accepted"]  # no one noted on what it stands
    bench.file.write_text(bench.file.read_text().replace("0, 1, 3, 2", "0, 1, 2, 3"))
    edited = bench.step("jog")
    assert (edited["accepted"], edited["lacks"]) == (False, "chambers not confirmed")
    assert edited["withdrawn"] == "valves.chambers changed since it was accepted"
    taken(bench.post("jog", "accept"))
    assert set(bench.rig().commissioned) == {"drivers", "jog"} and bench.rig().valves.chambers == (0, 1, 3, 2)
    taken(bench.post("drivers", "back"))
    assert bench.rig().commissioned == {} and bench.step("jog")["state"] == "todo"
    assert bench.state()["jog"] is None and bench.rig().stands_on == {}


def test_a_result_is_not_accepted_once_another_line_under_it_has_changed(bench: Bench) -> None:
    text = bench.file.read_text()
    note = KeptResult(good=True, text="both run", stands_on=marks("drivers", bench.rig().values(bench.file.parent)),
                      by="ann", at=datetime.now(UTC))  # fmt: skip
    bench.server.services.commissioning._store.keep("drivers", note)
    bench.file.write_text(text.replace("127.0.0.1", "127.0.0.9"))
    refused = bench.post("drivers", "accept")
    assert refused.status_code == 409
    assert refused.json()["detail"] == "motion_capture.options changed since Drivers was done: do it again"
    bench.file.write_text(text)
    taken(bench.post("drivers", "accept"))
    assert bench.step("drivers")["accepted"]


class Camera:
    """Raw points of a base that is touched and of the twin's tip, in a camera's coordinates."""

    def __init__(self, server: TestServer) -> None:
        self.history = server.services.history
        self.Q, self.place = camera(7)

    def __call__(self) -> Drivers:
        rows = self.history.newest
        assert rows is not None
        tip = np.array([*rows[0]["p_meas"], 0.0]) @ self.Q.T + self.place
        far = tip + np.array([0.0, 0.0, 0.5])
        values = {"wand": self.place.tolist(), "#1": far.tolist(), "#2": tip.tolist()}
        return Drivers(
            drivers=(driver_status("motion_capture", values), driver_status("valves", {"pressures": [0.0] * 4}))
        )


def test_three_captured_points_tell_the_frame_and_the_bent_one_needs_the_tip_before(bench: Bench) -> None:
    seen = Camera(bench.server)
    commissioning = bench.server.services.commissioning
    commissioning._parts = replace(commissioning._parts, drivers=seen)
    taken_drivers = bench.done("drivers")
    assert taken_drivers["result"].startswith("motion capture motion_capture 200/s")
    bench.accepted("drivers", "jog")
    bench.start("frame")

    def capture(place: str, point: str | None = None) -> Any:
        return bench.page.put("/api/commissioning/frame/capture", json={"place": place, "point": point})

    unnamed = capture("base")
    assert unnamed.status_code == 409 and "no point is named: motion capture sees wand, #1, #2" in unnamed.text
    assert "there is no point W" in capture("base", "W").json()["detail"]
    assert "capture the tip at rest first" in capture("bent", "#2").json()["detail"]
    assert [one["place"] for one in taken(capture("base", "wand")).json()["captured"]] == ["base"]
    taken(capture("tip", "#2"))
    assert bench.live.frames[-1]["mode"] == Mode.VENTED  # nothing moved so far
    taken(capture("bent", "#2"))
    found = bench.ended("frame")
    assert found["state"] == "done", found
    taken(bench.post("frame", "accept"))
    frame = bench.rig().motion_capture.frame
    axes, origin = np.array(frame.axes), np.array(frame.origin)
    assert frame.measured and axes @ seen.place + origin == pytest.approx([0.0, 0.0], abs=1e-6)
    left = np.array([0.1, 0.1, 0.0]) @ seen.Q.T + seen.place
    assert axes @ left + origin == pytest.approx([0.1, 0.1], abs=0.01)  # but for the set of the twin's rest
    assert bench.put_back()
    assert "tip, u1+ filled, as the camera sees it" in bench.page.get("/api/commissioning/report").text
    taken(bench.post("frame", "back"))
    assert not bench.rig().motion_capture.frame.measured and bench.state()["captured"] == []


def test_pressure_steps_write_the_dead_time_and_lag_of_the_twins_valves(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pressure, "HOLD_MIN_S", 0.5)
    bench.accepted("drivers", "jog")
    refused = bench.post("pressure", "start", pressure=150e3)
    assert refused.status_code == 202
    assert "is above 120648 Pa, half of full torque's" in bench.ended("pressure")["result"]
    found = bench.done("pressure", repeats=1)
    numbers = {one["name"]: one for one in found["numbers"]}
    assert numbers["dead time"]["value"] == pytest.approx(0.05, abs=0.006)
    assert numbers["lag"]["value"] == pytest.approx(0.055, abs=0.012)
    assert numbers["lag"]["low"] < numbers["lag"]["value"] < numbers["lag"]["high"]
    taken(bench.post("pressure", "accept"))
    rig = bench.rig()
    assert rig.valves.measured and rig.controller.dead_time == pytest.approx(numbers["dead time"]["value"], abs=1e-4)
    assert bench.page.get("/api/commissioning/report").text.count("<svg") == 4


def test_poses_and_decays_become_an_actuator_beside_the_rig_file(bench: Bench) -> None:
    bench.accepted("drivers", "jog", "frame", "signs", "pressure", "statics", "decay")
    missing = bench.start("identify") or bench.ended("identify")
    assert missing["state"] == "failed" and "poses.csv is missing" in missing["result"]
    folder = bench.server.settings.state / "commissioning-test"
    folder.mkdir(parents=True)
    for name in ("poses.csv", "decays.csv"):
        shutil.copy(EXAMPLES / name, folder / name)
    found = bench.done("identify")
    numbers = {one["name"]: one for one in found["numbers"]}
    assert numbers["ratio"]["value"] == pytest.approx(0.45 / 0.0751, rel=0.01)  # an arm of six times P1's stiffness
    taken(bench.post("identify", "accept"))
    assert re.fullmatch(r"test-identified-[0-9a-f]{8}\.toml", str(bench.rig().actuator))
    actuator = bench.rig().found_actuator(bench.file.parent)
    assert actuator.k[0] == pytest.approx(0.45, rel=0.01) and actuator.name == "test-identified"
    modes = bench.server.services.modes
    assert modes.of(actuator) is None, "no decay has told a mode"
    mode = first_mode(zeta=0.11)
    decay = KeptResult(
        good=True,
        text="told",
        data={"mode": mode.model_dump(mode="json")},
        by="ann",
        at=datetime(2026, 11, 26, tzinfo=UTC),
    )
    bench.server.services.commissioning._store.keep("decay", decay)
    told = {one["name"]: one["value"] for one in bench.done("identify")["numbers"]}
    taken(bench.post("identify", "accept"))
    kept = modes.of(bench.rig().found_actuator(bench.file.parent), "rod")
    assert kept is not None and kept.measured == decay.at, "the gains' margins rest on it from now on"
    assert kept.mode.zeta.value == mode.zeta.value and kept.mode.kappa.value == pytest.approx(told["kappa"])
    (folder / "poses.csv").write_text("p1,x1\n1,nonsense\n")
    broken = bench.start("identify") or bench.ended("identify")
    assert broken["state"] == "failed" and "poses.csv" in broken["result"] and "nonsense" in broken["result"]


def test_an_actuator_identified_anew_is_put_in_force_and_asks_for_what_rests_on_it(bench: Bench) -> None:
    before = ("drivers", "jog", "frame", "signs", "pressure", "statics", "decay")
    bench.accepted(*before)
    folder, ordered = bench.server.settings.state / "commissioning-test", bench.server.settings.restarts
    assert ordered is not None
    folder.mkdir(parents=True)
    shutil.copy(EXAMPLES / "decays.csv", folder / "decays.csv")
    order = ordered.with_name("rig.json")

    def identified(stiffer: float) -> None:
        head, *rows = (EXAMPLES / "poses.csv").read_text().split()
        cells = [[float(cell) for cell in row.split(",")] for row in rows]
        lines = [",".join(map(str, [stiffer * p1, stiffer * p2, *points])) for p1, p2, *points in cells]
        (folder / "poses.csv").write_text("\n".join([head, *lines]) + "\n")
        bench.done("identify")

    def named() -> str:
        return (bench.file.parent / str(bench.rig().actuator)).read_text()

    identified(1.0)
    taken(bench.post("identify", "accept"))
    first, file = named(), bench.file.parent / str(bench.rig().actuator)
    order.unlink()
    told = {**bench.rig().commissioned, "closed_loop": "accepted before"}
    text = changed(bench.file.read_text(), {"commissioned": told}, bench.file.name)
    bench.file.write_text(noted(text, bench.file, "closed_loop"))

    identified(1.3)
    taken(bench.page.post("/api/recordings", json={}))
    refused = bench.post("identify", "accept")
    assert refused.status_code == 409 and "recording" in refused.json()["detail"]
    assert (named(), bench.rig().commissioned) == (first, told) and not order.exists()

    taken(bench.page.delete("/api/recordings/current"))
    taken(bench.post("identify", "accept"))
    k = RigParameters.model_validate_json(order.read_bytes()).actuator.k[0]
    assert k == bench.rig().found_actuator(bench.file.parent).k[0] == pytest.approx(1.3 * 0.45, rel=0.01)
    assert file.read_text() == first, "who goes back to it finds it as it was"
    assert "closed_loop" not in bench.rig().commissioned and not bench.step("closed_loop")["accepted"]

    order.unlink()
    taken(bench.post("identify", "accept"))
    assert not order.exists(), "that is in force already"


@pytest.mark.long
def test_the_twin_goes_through_every_step_that_moves_it(bench: Bench) -> None:
    bench.accepted("drivers", "jog", "frame")
    for step, body in (
        ("signs", {}),
        ("pressure", {}),
        ("statics", {"grid": 4}),
        ("decay", {"repeats": 1}),
        ("identify", {}),
        ("closed_loop", {"repeats": 2}),
    ):
        bench.done(step, **body)
        taken(bench.post(step, "accept"))
    identified = {one["name"]: one["value"] for one in bench.step("identify")["numbers"]}
    assert 0.85 < identified["ratio"] < 1.0  # the twin's pairs bend it by 6 to 10 % more than the model believes
    loop = {one["name"]: one["value"] for one in bench.step("closed_loop")["numbers"]}
    assert loop["tip RMSE"] < 6e-3
    assert bench.state()["missing"] == []
