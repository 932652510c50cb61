"""Presets of gains, and another actuator for a rig that is this server's own."""

from pathlib import Path

import pytest

from controller.actuator import PRESETS, write_actuator
from controller.fit import GAINS
from controller.modes import Mode
from controller.realtime.settings import RigSettings
from server.presets.actuator import keep, kept_file, take_order
from server.presets.messages import ActuatorBody
from server.settings import ServerSettings
from server.up import with_last_actuator
from tests.server.live_server import TestServer

K_FF = GAINS["K_FF"]


def test_gains_are_saved_under_a_name_read_back_and_deleted(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    before = operator.get("/api/settings").json()
    assert operator.patch("/api/settings", json={"changes": {"K_P": [0.7, 0.8]}}).status_code == 200
    assert viewer.put("/api/gains/soft").status_code == 403
    assert operator.put("/api/gains/so%2Fft").status_code in (404, 422)
    saved = operator.put("/api/gains/soft").json()
    ours = saved.pop(0)
    assert (ours["built_in"], ours["settings"]["K_FF"], ours["settings"]["K_P"]) == (True, [K_FF, K_FF], before["K_P"])
    assert [(preset["name"], preset["settings"]["K_P"]) for preset in saved] == [("soft", [0.7, 0.8])]
    assert operator.patch("/api/settings", json={"changes": {"K_P": before["K_P"]}}).status_code == 200
    assert viewer.get("/api/gains").json() == [ours, *saved]
    for method in ("PUT", "DELETE"):
        refused = operator.request(method, f"/api/gains/{ours['name']}")
        assert (refused.status_code, "another name" in refused.text) == (409, True)
    assert operator.delete("/api/gains/soft").json() == [ours]


def test_another_actuator_is_ordered_from_rest_only_and_refused_where_the_rig_is_not_ours(
    server: TestServer, tmp_path: Path
) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    refused = operator.put("/api/rig/actuator", json={"name": "P2"})
    assert (refused.status_code, "where it runs" in refused.text) == (409, True)
    assert "where it runs" in viewer.get("/api/rig/actuator").json()["reason"]
    server.services.settings.orders = tmp_path / "actuator.json"
    assert viewer.put("/api/rig/actuator", json={"name": "P2"}).status_code == 403
    assert "P1, P2, P3" in operator.put("/api/rig/actuator", json={"name": "P9"}).text
    wrong = operator.put("/api/rig/actuator", json={"toml": 'name = "X"\nlength = -1'})
    assert (wrong.status_code, "the file" in wrong.text) == (422, True)
    with operator.live() as live:
        live.operate()
        assert operator.command("arm").status_code == 200
        live.wait_mode(Mode.HOLD)
        armed = operator.put("/api/rig/actuator", json={"name": "P2"})
        assert (armed.status_code, "disarm first" in armed.text) == (409, True)
        assert take_order(tmp_path / "actuator.json") is None
        operator.command("e_stop")
        operator.command("clear")
        live.wait_mode(Mode.VENTED)
    file = tmp_path / "own.toml"
    write_actuator(PRESETS["P3"].model_copy(update={"name": "Own"}), file)
    assert operator.put("/api/rig/actuator", json={"toml": file.read_text()}).status_code == 202
    assert "Own" in kept_file(server.services.settings).read_text()
    ordered = take_order(tmp_path / "actuator.json")
    assert ordered == PRESETS["P3"].model_copy(update={"name": "Own"})
    assert take_order(tmp_path / "actuator.json") is None


def test_the_next_start_has_the_actuator_that_was_chosen_last_and_the_default_where_that_fails(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    server, rig = ServerSettings(rig="arm", state=tmp_path), RigSettings(rig="arm")
    own = PRESETS["P3"].model_copy(update={"name": "Own"})
    write_actuator(own, tmp_path / "own.toml")
    assert with_last_actuator(rig, server) == rig, "nothing was chosen yet"
    for body, wanted in [
        (ActuatorBody(name="P2"), PRESETS["P2"]),
        (ActuatorBody(toml=(tmp_path / "own.toml").read_text()), own),
    ]:
        keep(kept_file(server), body)
        assert with_last_actuator(rig, server).parameters.actuator == wanted
    assert caplog.text == ""
    for text, complaint in [
        ('{"name": "P9"}', "'P9' is not one of P1, P2, P3"),
        ('{"na', "is damaged"),
        ('{"toml": "length = -1"}', "name"),
    ]:
        kept_file(server).write_text(text)
        assert with_last_actuator(rig, server) == rig
        assert complaint in caplog.text
        assert str(kept_file(server)) in caplog.text
        caplog.clear()
