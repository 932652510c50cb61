"""The first mode measured on a real rig: kept and told, ended by any stop, and everything put back."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from controller.errors import ParameterError
from controller.schema.actuator import PRESETS
from controller.schema.modes import Law, Mode
from controller.schema.parameters import RigParameters
from server.cli.research.stability import Wanted, plant_of, plant_words
from server.hardware.first_mode.messages import Interval, KeptMode, MeasuredMode
from server.hardware.first_mode.store import FirstModes, modes_file
from tests.server.live_server import VIEWER_TOKEN, Live, Page, TestServer, wait_for
from tests.server.runs.test_macros import logged
from tests.server.runs.test_runs import armed

pytestmark = pytest.mark.keyed()

TWICE = {"travel": 0.1, "repeats": 2}


def told(live: Live) -> dict[str, Any]:
    """The newest state of the measurement that the page was told."""
    states = [text["first_mode"] for text in live.texts if text["type"] == "status" and text["first_mode"]]
    return states[-1] if states else {"state": None, "step": 0, "reason": ""}


def measure(page: Page) -> None:
    answer = page.post("/api/first-mode/measure", json=TWICE)
    assert answer.status_code == 202, answer.text


def wait_end(live: Live) -> dict[str, Any]:
    wait_for(lambda: told(live)["state"] in ("done", "ended"), "the measurement's end")
    return told(live)


def put_back(page: Page, law: int = Law.FF_PI) -> bool:
    found = page.get("/api/settings").json()
    return (found["law"], found["u_open"]) == (law, [0.0, 0.0])


def test_damping_and_kappa_are_assumed_until_they_are_measured_and_then_told_to_everybody(server: TestServer) -> None:
    viewer = server.page().sign_in(VIEWER_TOKEN)
    with armed(server) as (page, live):
        assert page.post("/api/first-mode/stop").json()["detail"] == "no first mode is being measured"
        twin = server.services.rig.require_info().parameters.twin
        before = viewer.get("/api/first-mode").json()
        assert (before["actuator"], before["mode"]) == ("P1", None)
        assert [before[name][key] for name in ("zeta", "kappa") for key in ("value", "source", "note")] == [
            *(twin.zeta, "assumed", "fit to the paper"),
            *(twin.kappa, "assumed", "fit to the paper"),
        ]
        measure(page)
        again = page.post("/api/first-mode/measure", json=TWICE)
        assert (again.status_code, "already" in again.json()["detail"]) == (409, True)
        done = wait_end(live)
        assert (done["state"], done["reason"], done["step"], done["steps"]) == ("done", "", 4, 4), logged(live)
        straight = (PRESETS["P1"].length, 0.0)  # where it began depends on what moved the arm before: hysteresis
        assert live.wait_mode(Mode.HOLD)["p_hat"] == pytest.approx(straight, abs=0.05)
        assert put_back(page)
        found = viewer.get("/api/first-mode").json()
        assert [found[name]["source"] for name in ("zeta", "kappa")] == ["measured", "measured"]
        assert found["zeta"]["low"] <= found["zeta"]["value"] <= found["zeta"]["high"]
        assert found["zeta"]["value"] == pytest.approx(twin.zeta, rel=0.3)
        assert twin.kappa < found["kappa"]["value"] < 2.0 * twin.kappa  # friction and creep stiffen small motions
        assert found["mode"]["pressures"] and found["mode"]["misfit"] < 0.1
    kept = FirstModes(modes_file(server.services.settings.state, server.services.settings.rig))
    assert kept.of(PRESETS["P1"], "rod") is not None
    assert kept.of(PRESETS["P1"], "hardware") is None and kept.of(PRESETS["P2"]) is None
    assert kept.of(PRESETS["P1"].model_copy(update={"mass": 0.13})) is None


@pytest.mark.parametrize("stop", ["e_stop", "hold", "rest", "stop", "target", "settings", "release", "leave"])
def test_any_stop_ends_the_measurement_names_what_happened_and_puts_law_and_torques_back(
    stop: str, server: TestServer
) -> None:
    with armed(server) as (page, live):
        measure(page)
        wait_for(lambda: told(live)["step"] >= 1 or told(live)["state"] == "ended", "its first step")
        assert told(live)["state"] == "running", told(live)
        assert page.get("/api/settings").json()["law"] == Law.OPEN_LOOP
        match stop:
            case "stop":
                page.post("/api/first-mode/stop")
            case "target":
                live.send(type="target", id=1, x=0.2, y=0.1, start=False)
            case "settings":
                page.patch("/api/settings", json={"changes": {"law": Law.FF}})
            case "release":
                page.delete("/api/lease")
            case "leave":
                live.operate(present=False)
            case _:
                page.command(stop)
        ended = wait_end(live)
        reason = {
            "e_stop": "E-STOP",
            "hold": f"HOLD, asked for by {ended['by']}",
            "rest": f"REST, asked for by {ended['by']}",
            "stop": f"stopped by {ended['by']}",
            "target": f"another target, asked for by {ended['by']}",
            "settings": "the settings were changed",
            "release": f"{ended['by']} no longer operates",
            "leave": "the rig is in HOLD (operator lost)",
        }
        assert (ended["state"], ended["reason"]) == ("ended", reason[stop])
        mode = {"e_stop": Mode.E_STOP, "rest": Mode.VENTED, "target": Mode.FOLLOW}
        live.wait_mode(mode.get(stop, Mode.HOLD))
        wait_for(lambda: put_back(page, Law.FF if stop == "settings" else Law.FF_PI), "law and torques put back")
        assert page.get("/api/first-mode").json()["zeta"]["source"] == "assumed"


def test_it_is_refused_with_a_reason_where_nothing_may_move(server: TestServer) -> None:
    page, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    assert viewer.post("/api/first-mode/measure", json=TWICE).status_code == 403
    vented = page.post("/api/first-mode/measure", json=TWICE)
    assert vented.json()["detail"] == "the first mode is measured from HOLD or FOLLOW, and the rig is in VENTED"
    with page.live() as live:
        live.operate()
        page.command("arm")
        live.wait_mode(Mode.HOLD)
        wide = page.post("/api/first-mode/measure", json={"travel": 0.3})
        assert wide.status_code == 422 and "travel" in wide.text


def number(value: float) -> Interval:
    return Interval(value=value, low=0.9 * value, high=1.1 * value)


def test_the_stability_command_takes_what_a_rig_measured_of_this_very_actuator(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TENDRIL_STATE", str(tmp_path))
    mode = MeasuredMode(
        frequency=number(2.0), zeta=number(0.2), kappa=number(16.4), friction=0.0, delay=0.01, misfit=0.02,
        pressures=True, travel=0.1, repeats=3,
    )  # fmt: skip
    kept = KeptMode(actuator=PRESETS["P1"], plant="hardware", measured=datetime(2026, 11, 26, tzinfo=UTC), mode=mode)
    FirstModes(modes_file(tmp_path, "lab")).keep(kept)
    wanted = Wanted("10", 100.0, 0.0, rig="lab")
    plant = plant_of(RigParameters(), wanted)
    assert plant_words(plant) == [
        "damping ratio 0.2 (0.18 to 0.22, measured 2026-11-26)",
        "kappa 16.4 (14.8 to 18, measured 2026-11-26)",
    ]
    assert plant_of(RigParameters(), wanted._replace(zeta=0.3))["zeta"].source == "given"
    with pytest.raises(ParameterError, match="no first mode of actuator P2 is kept"):
        plant_of(RigParameters(actuator=PRESETS["P2"]), wanted)


def test_a_damaged_file_counts_as_not_measured_and_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    modes_file(tmp_path, "lab").write_text('[{"actuator": ')
    assert FirstModes(modes_file(tmp_path, "lab")).of(PRESETS["P1"]) is None
    assert "damping and kappa count as not measured" in caplog.text
