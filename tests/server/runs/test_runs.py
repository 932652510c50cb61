"""Runs on a real rig: followed, paused, gone on with, ended, refused, and kept."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from controller.arrays import Rows
from controller.schema.modes import Mode
from recordings.read.reader import read_rows
from server.runs.results import Results
from tests.server.live_server import Live, Page, TestServer, taken, wait_for

pytestmark = pytest.mark.alone

ANGLE = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
CIRCLE = np.column_stack([0.05 + 5e-3 * np.cos(ANGLE), 0.14 + 5e-3 * np.sin(ANGLE)]).tolist()


def ring(seconds: float, laps: int | None = 1) -> dict[str, Any]:
    """Body of a run of a small circle."""
    timing = {"kind": "duration", "duration": seconds}
    return {"drawing": {"name": "ring", "points": CIRCLE, "closed": True, "timing": timing}, "laps": laps}


def lead(server: TestServer) -> int:
    """Ticks that lead into the leg under way; within the limits they take 2 s from rest, or 0.5 s back, at least."""
    run = server.services.runs._run
    assert run is not None
    return run._leg.again


@contextmanager
def armed(server: TestServer) -> Iterator[tuple[Page, Live]]:
    """An operator whose page shows presence, with the rig in HOLD, from rest."""
    page = server.operator()
    with page.live() as live:
        live.wait_still()
        live.operate()
        answer = page.command("arm")
        assert answer.status_code == 200, answer.text
        live.wait_mode(Mode.HOLD)
        yield page, live


def run(live: Live) -> dict[str, Any]:
    """The newest state of the run that the page was told."""
    told = [text["run"] for text in live.texts if text["type"] == "status" and text["run"]]
    return told[-1] if told else {"state": None, "progress": 0.0, "lap": 0}


def wait_run(live: Live, what: Callable[[dict[str, Any]], bool], id: int | None = None) -> dict[str, Any]:
    """Wait until the run (of this number, where another one was before) is so, or has ended."""
    ended = {"done", "stopped", "broken off"}
    wait_for(lambda: id in (None, run(live).get("id")), "the run to begin")
    wait_for(lambda: what(run(live)) or run(live)["state"] in ended, "the run")
    found = run(live)
    assert what(found), (found["state"], found["reason"])
    return found


def test_a_run_is_paused_resumed_and_finished_and_its_result_is_that_of_its_rows(server: TestServer) -> None:
    batches: list[Rows] = []
    server.services.history.listen(batches.append)
    with armed(server) as (page, live):
        begun = page.run(json=ring(1.5, laps=2)).json()
        assert (begun["state"], begun["duration"], begun["laps"], begun["progress"]) == ("approach", 1.5, 2, 0.0), begun
        second = page.run(json=ring(1.5))
        assert second.status_code == 409 and "stop it first" in second.json()["detail"]
        wait_run(live, lambda state: state["progress"] > 0.1)
        paused = page.post("/api/run/pause").json()
        assert paused["state"] == "paused" and live.wait_mode(Mode.HOLD)
        leads = [lead(server)]
        resumed = page.post("/api/run/resume").json()
        leads.append(lead(server))
        assert (resumed["state"], resumed["progress"]) == ("approach", paused["progress"])
        done = wait_run(live, lambda state: state["state"] == "done")
        assert (done["progress"], done["lap"], done["reason"]) == (1.0, 2, "")
        assert done["elapsed"] == pytest.approx(1e-3 * sum(leads) + 3.0, abs=2e-3)
        result = page.get("/api/runs").json()[0]
        assert live.wait("status", lambda status: status["result"] == result)
        told = [text["text"].split()[3] for text in live.texts if text.get("text", "").startswith("run ")]
        assert [word.strip(",") for word in told] == ["started", "paused", "resumed", "done"]
    judged = shape(np.concatenate(batches), tuple(leads))
    error = np.linalg.norm(judged["p_ref"] - judged["p_meas"], axis=1)
    assert len(error) == 3000
    error = error[np.isfinite(error)]  # on a machine that is busy the camera may be late
    assert result["rmse"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-6)
    assert result["max_error"] == pytest.approx(error.max(), rel=1e-6)
    assert result["saturated_share"] == np.mean(judged["saturated"])
    assert (result["laps"], result["state"]) == (2.0, "done")
    assert -90.0 < result["lag_deg_x"] < 90.0
    kept = server.settings.state / "runs-test.json"  # written beside the answer, on a slow disk later than it
    wait_for(lambda: Results(kept).newest == server.services.runs.last(), "the result in its file")


def test_the_last_run_is_followed_again_without_an_approach_or_from_its_recording(server: TestServer) -> None:
    with armed(server) as (page, live):
        nothing = page.post("/api/run/again")
        assert nothing.status_code == 409 and "no run has begun since the server started" in nothing.json()["detail"]
        assert server.page().sign_in().post("/api/run/again").status_code == 403
        first = page.run(json=ring(1.5)).json()
        wait_run(live, lambda state: state["state"] == "done")
        assert lead(server) >= 2000
        again = page.post("/api/run/again").json()
        assert (again["id"], again["name"], again["duration"]) == (first["id"] + 1, "ring", first["duration"])
        assert lead(server) <= 400, "the tip stands where the ring begins"
        wait_run(live, lambda state: state["state"] == "done", again["id"])
        card, before = page.get("/api/runs").json()
        assert card["recording"] != before["recording"], "though the one before was still being ended"
        kept = wait_for(lambda: page.get(f"/api/recordings/{card['recording']}").json()["metrics"], "the metrics")
        whole, run = (
            page.get(f"/api/recordings/{card['recording']}/path", params={"what": "p_ref", "run": run}).json()
            for run in (False, True)
        )
    assert card["rmse"] == pytest.approx(kept["rmse"], abs=1e-5), "its lead-in counts in neither"
    assert kept["approach"] == pytest.approx(1e-3 * lead(server), abs=0.01)
    rows = read_rows(server.services.folder.store.path(card["recording"]), ("t_ns", "mode"))
    lasted = 1e-9 * np.ptp(rows["t_ns"][rows["mode"] == Mode.TRACK][-1500:])  # 1.5 s, and what the machine paused in it
    assert run["times"][-1] == pytest.approx(lasted, abs=0.01) and whole["times"][-1] > run["times"][-1] + 0.1
    assert run["points"][0] == pytest.approx(CIRCLE[0], abs=2e-4)


def test_stop_ends_a_paused_run_its_recording_and_its_reading_of_rows(server: TestServer) -> None:
    with armed(server) as (page, live):
        begun = page.run(json=ring(1.0, laps=None))
        assert begun.status_code == 200, begun.text
        wait_run(live, lambda state: state["progress"] > 0.1)
        assert page.post("/api/run/pause").json()["state"] == "paused"
        stopped = page.post("/api/run/stop").json()
        assert stopped["state"] == "stopped" and stopped["reason"].startswith("by ")
        result = page.get("/api/runs").json()[0]
        assert (result["id"], result["state"]) == (stopped["id"], "stopped")
        wait_for(lambda: not server.services.recorder.state().recording, "the end of the recording")
        assert not server.services.runs.inbox.is_open and not len(server.services.runs.inbox)
        assert page.run(json=ring(1.0)).json()["state"] == "approach"
        taken(page.post("/api/run/stop"))


def test_a_run_that_a_stopped_rig_refuses_leaves_nothing_open(server: TestServer) -> None:
    with armed(server) as (page, live):
        assert page.command("e_stop").status_code == 200
        refused = page.run(json=ring(1.0))
        assert refused.status_code == 409 and "clear the E-STOP first" in refused.json()["detail"]
        assert not server.services.runs.inbox.is_open
        assert not server.services.recorder.state().recording
        page.command("clear")
        page.command("arm")
        live.wait_mode(Mode.HOLD)
        taken(page.run(json=ring(1.0)))
        taken(page.post("/api/run/stop"))


def shape(rows: Rows, leads: tuple[int, ...]) -> Rows:
    """Rows of the shape: those in TRACK but for the `leads` into each leg [ticks]."""
    on = rows["mode"] == Mode.TRACK
    begins = np.flatnonzero(on & ~np.roll(on, 1))
    for begin, ticks in zip(begins, leads, strict=True):
        on[begin : begin + ticks] = False
    found: Rows = rows[on]
    return found


@pytest.mark.parametrize("paused", [False, True])
def test_a_recordings_metrics_are_those_of_its_runs_card(server: TestServer, paused: bool) -> None:
    batches: list[Rows] = []
    server.services.history.listen(batches.append)
    with armed(server) as (page, live):
        page.run(json=ring(1.0, laps=2))
        leads = [lead(server)]
        if paused:
            wait_run(live, lambda state: state["progress"] > 0.1)
            page.post("/api/run/pause")
            page.post("/api/run/resume")
            leads.append(lead(server))
        wait_run(live, lambda state: state["state"] == "done")
        card = page.get("/api/runs").json()[0]
        kept = wait_for(lambda: page.get(f"/api/recordings/{card['recording']}").json()["metrics"], "the metrics")
    e = judged_errors(np.concatenate(batches), tuple(leads))
    assert kept["approach"] == pytest.approx(1e-3 * sum(leads), rel=1e-2)
    for name in ("rmse", "max_error"):
        assert kept[name] == pytest.approx(card[name], abs=1e-5), name  # the profile `standard` rounds to 7.6 um
    assert kept["rmse"] == pytest.approx(card["rmse"], rel=5e-3)
    assert kept["sse"] == pytest.approx(np.linalg.norm(e[-len(e) // 10 :], axis=1).mean(), abs=1e-5)
    assert kept["saturated_share"] == card["saturated_share"]
    for name in ("lag_deg_x", "lag_deg_y"):
        assert kept[name] == pytest.approx(card[name], abs=0.2), name


def judged_errors(rows: Rows, leads: tuple[int, ...]) -> np.ndarray:
    """Errors (k, 2) [m] of a run's rows but for those that lead into it, where the tip was seen."""
    judged = shape(rows, leads)
    e: np.ndarray = judged["p_ref"] - judged["p_meas"]
    return e[np.isfinite(e).all(axis=1)]


def test_without_its_operator_a_run_is_broken_off_and_nothing_goes_on_by_itself(server: TestServer) -> None:
    with armed(server) as (page, live):
        started = page.post("/api/recordings", json={"name": "with"}).json()
        begun = page.run(json=ring(1.0, laps=None)).json()
        assert (begun["laps"], begun["recording"]) == (None, started["id"])
        wait_run(live, lambda state: state["lap"] > 2)
        live.operate(False)
        ended = wait_run(live, lambda state: state["state"] == "broken off")
        assert ended["reason"] == "HOLD (operator lost)"
        assert page.delete("/api/recordings/current").status_code == 200
        result = page.get("/api/runs").json()[0]
        assert result["laps"] > 2 and result["recording"] == started["id"]
        live.operate()
        for verb in ("pause", "resume", "stop"):
            assert page.post(f"/api/run/{verb}").json()["detail"] == "no run is under way"
        assert server.services.history.newest is not None
        assert server.services.history.newest[0]["mode"] == Mode.HOLD


def test_what_cannot_be_run_is_refused_with_its_reason(server: TestServer) -> None:
    page = server.operator()
    rig = server.services.rig
    wait_for(lambda: rig.newest is not None and rig.newest[0]["mode"] == Mode.VENTED, "a row of the cleared rig")
    vented = page.run(json=ring(1.0))
    assert vented.status_code == 409 and vented.json()["detail"].endswith("is not possible in VENTED; arm first")
    viewer = server.page().sign_in()
    assert viewer.run(json=ring(1.0)).status_code == 403
    assert viewer.post("/api/run/stop").status_code == 403
    assert viewer.get("/api/runs").status_code == 200
    for body in ({}, ring(1.0) | {"reference": "vu"}, ring(1.0, laps=0), ring(1.0, laps=1001), ring(1e3)):
        assert page.run(json=body).status_code == 422, body
    with page.live() as live:
        live.operate()
        page.command("arm")
        live.wait_mode(Mode.HOLD)
        assert page.run(json={"reference": "spiral"}).status_code == 404
        far = ring(1.0)
        far["drawing"] |= {"points": [[0.4, 0.0], [0.4, 0.1]], "closed": False, "outside": "refuse"}
        outside = page.run(json=far)
        assert outside.status_code == 422 and "out of reach" in outside.json()["detail"]
        page.patch("/api/settings", json={"changes": {"law": 0}})
        assert "open loop" in page.run(json=ring(1.0)).json()["detail"]
        page.patch("/api/settings", json={"changes": {"law": 4}})
    assert server.services.runs.state() is None
