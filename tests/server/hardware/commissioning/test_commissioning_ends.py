"""A step of the commissioning that is ended in each way there is: rig, server and settings after it."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from controller.schema.modes import Law, Mode
from controller.schema.parameters import Settings
from tests.server.commissioning_bench import Bench, bench_of
from tests.server.live_server import RigProcess, taken, wait_for

pytestmark = pytest.mark.keyed()


@pytest.fixture
def bench(shared_rig: RigProcess, tmp_path: Path) -> Iterator[Bench]:
    with bench_of(shared_rig.endpoint, tmp_path) as found:
        yield found


@pytest.mark.parametrize("stop", ["e_stop", "hold", "stop", "target", "settings", "release", "leave"])
def test_whatever_ends_a_step_leaves_the_rig_vented_or_stopped_and_the_settings_as_they_were(
    stop: str, bench: Bench
) -> None:
    bench.accepted("drivers", "jog", "frame")
    page, live = bench.page, bench.live
    bench.start("signs")
    again = bench.post("signs", "start")
    assert again.status_code == 409 and "Signs is under way: stop it first" in again.json()["detail"]
    wait_for(lambda: live.frames[-1]["mode"] == Mode.FOLLOW and live.frames[-1]["u"][0] > 0.0, "u1+ to fill")
    who = bench.state()["running"]["by"]
    match stop:
        case "stop":
            taken(bench.post("signs", "stop"))
        case "target":
            live.send(type="target", id=1, x=0.2, y=0.1, start=False)
        case "settings":
            page.patch("/api/settings", json={"changes": {"K_P": [0.1, 0.1]}})
        case "release":
            page.delete("/api/lease")
        case "leave":
            live.operate(present=False)
        case _:
            page.command(stop)
    reason = {
        "e_stop": "E-STOP",
        "hold": f"HOLD, asked for by {who}",
        "stop": f"stopped by {who}",
        "target": f"another target, asked for by {who}",
        "settings": "the settings were changed",
        "release": f"{who} no longer operates",
        "leave": "the rig is in HOLD (operator lost)",
    }
    found = bench.ended("signs")
    assert found["state"] == "failed" and found["result"] == f"ended at “fills u1+”: {reason[stop]}"
    live.wait_mode(Mode.E_STOP if stop == "e_stop" else Mode.VENTED)
    assert bench.put_back()
    assert page.get("/api/settings").json()["K_P"] != [0.1, 0.1] or stop == "settings"
    if stop != "release":
        refused = bench.post("signs", "accept")
        assert refused.status_code == 409 and "Signs has no result to accept" in refused.json()["detail"]


@pytest.mark.process
def test_a_killed_rig_ends_the_step_and_the_next_one_gets_the_operators_settings(tmp_path: Path) -> None:
    (tmp_path / "rig").mkdir()
    rig = RigProcess(tmp_path / "rig")
    try:
        with bench_of(rig.endpoint, tmp_path) as bench:
            bench.accepted("drivers", "jog", "frame")
            bench.start("signs")
            bench.wait_doing("fills u1+")
            rig.kill()
            wait_for(lambda: not bench.server.services.commissioning._run.running, "the end")  # type: ignore[union-attr]
            rig.start()
            found = bench.ended("signs")
            assert found["state"] == "failed" and "the rig" in found["result"]
            wait_for(bench.put_back, "the settings")
    finally:
        rig.stop()


def test_a_server_that_ends_in_the_middle_of_a_step_ends_in_order_and_gives_the_settings_back(
    shared_rig: RigProcess, tmp_path: Path
) -> None:
    with bench_of(shared_rig.endpoint, tmp_path) as bench:
        before = bench.server.services.operator.settings
        bench.accepted("drivers", "jog", "frame")
        bench.start("signs")
        bench.wait_doing("fills u1+")
    kept = Settings.model_validate_json((tmp_path / "state" / "settings-test.json").read_bytes())
    left = bench.server.services.commissioning._store.kept.borrowed
    assert kept == before or left == before, "what is not put back yet is known to the next server"
    with bench_of(shared_rig.endpoint, tmp_path) as bench:
        wait_for(bench.put_back, "the settings")
        assert bench.step("signs")["result"] == "ended at “fills u1+”: the server ended"


def test_a_server_that_died_in_the_middle_of_a_step_gives_the_settings_back_at_its_next_start(
    shared_rig: RigProcess, tmp_path: Path
) -> None:
    with bench_of(shared_rig.endpoint, tmp_path) as bench:
        operator, commissioning = bench.server.services.operator, bench.server.services.commissioning
        before = operator.settings
        commissioning._store.note_override(before)
        kept = tmp_path / "state" / "settings-test.json"
        kept.write_text(before.model_copy(update={"law": Law.OPEN_LOOP, "sensed": 0}).model_dump_json())
        wait_for(lambda: commissioning._store.kept.borrowed is None, "this server to give them back")
        commissioning._store.note_override(before)  # as a dead one leaves it
        bench.server.services.operator.close()
        kept.write_text(before.model_copy(update={"law": Law.OPEN_LOOP, "sensed": 0}).model_dump_json())
    with bench_of(shared_rig.endpoint, tmp_path) as bench:
        wait_for(bench.put_back, "the settings")
        wait_for(lambda: bench.server.services.commissioning._store.kept.borrowed is None, "that to be noted")
