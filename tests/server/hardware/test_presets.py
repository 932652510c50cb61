"""Presets of gains, and another actuator for a rig that is this server's own."""

import json
import os
import re
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

from controller.realtime.settings import RigSettings
from controller.realtime.supervisor import Started
from controller.schema.actuator import PRESETS, write_actuator
from controller.schema.fit import GAINS, TWIN
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters, TwinParameters
from server.access.permit import Permit
from server.app.up import with_last_actuator
from server.hardware.actuator import keep, kept_file, with_observer_kappa, with_other_actuator
from server.hardware.messages import ActuatorBody, ActuatorOutcome
from server.hardware.outcomes import OutcomeWatch
from server.hardware.restart_files import request_rig, take_actuator, take_choice, take_rig, tell_outcome
from server.hardware.restarts import Restarts
from server.log.events import EventLog
from server.settings import ServerSettings
from tests.controller.anything import actuators
from tests.controller.live_rig import wait_for
from tests.server.live_server import TestServer

pytestmark = pytest.mark.keyed()

K_FF = GAINS["K_FF"]
LONG = os.environ.get("TENDRIL_LONG") == "1"


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
    server.services.settings.restarts = tmp_path / "actuator.json"
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
        assert take_actuator(tmp_path / "actuator.json") is None
        operator.command("e_stop")
        operator.command("clear")
        live.wait_mode(Mode.VENTED)
    file = tmp_path / "own.toml"
    write_actuator(PRESETS["P3"].model_copy(update={"name": "Own"}), file)
    assert operator.put("/api/rig/actuator", json={"toml": file.read_text()}).status_code == 202
    assert not kept_file(server.services.settings).exists(), "the rig has not ticked with it"
    choice = take_choice(tmp_path / "actuator.json")
    assert choice is not None and choice.toml is not None and "Own" in choice.toml
    ordered = take_actuator(tmp_path / "actuator.json")
    assert ordered == PRESETS["P3"].model_copy(update={"name": "Own"})
    assert take_actuator(tmp_path / "actuator.json") is None


def test_the_next_start_has_the_actuator_chosen_last_or_the_default_where_that_fails(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    server, rig = ServerSettings(rig="arm", state=tmp_path), RigParameters()
    own = PRESETS["P3"].model_copy(update={"name": "Own"})
    write_actuator(own, tmp_path / "own.toml")
    assert with_last_actuator(rig, server) == rig, "nothing was chosen yet"
    for body, wanted in [
        (ActuatorBody(name="P2"), PRESETS["P2"]),
        (ActuatorBody(toml=(tmp_path / "own.toml").read_text()), own),
    ]:
        keep(kept_file(server), body)
        assert with_last_actuator(rig, server) == with_other_actuator(rig, wanted)
        assert with_last_actuator(rig, server, 7.0) == with_other_actuator(rig, wanted, 7.0)
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


UNBUILDABLE = """
name = "toppled"
mass = 10
length = 2.0
table_rods = 2
k = 5.0
b = 0.0
alpha = 0.0
gravity = [-9.81, 0.0]
chambers = [[0, 1], [1, 2]]
"""
"""Gravity topples it: neither observer nor twin has a rest."""


def test_an_actuator_with_which_no_rig_would_start_is_refused_and_nothing_is_kept(
    server: TestServer, tmp_path: Path
) -> None:
    operator = server.operator()
    server.services.settings.restarts = tmp_path / "actuator.json"
    for toml, complaint in [
        (UNBUILDABLE, "gravity = (-9.81, 0.0) m/s^2: the unactuated body has no stable rest"),
        (UNBUILDABLE.replace("k = 5", "k = 1e-300 # "), "k.0 = 1e-300"),
    ]:
        refused = operator.put("/api/rig/actuator", json={"toml": toml})
        assert (refused.status_code, complaint in refused.json()["detail"]) == (422, True), refused.text
    assert take_actuator(tmp_path / "actuator.json") is None
    assert not kept_file(server.services.settings).exists()


@pytest.mark.timeout(3600 if LONG else 120)
def test_the_route_answers_any_actuator_by_taking_it_or_by_a_sentence(server: TestServer, tmp_path: Path) -> None:
    operator = server.operator()
    server.services.settings.restarts = tmp_path / "actuator.json"
    answered: dict[int, int] = {}

    @settings(
        max_examples=300 if LONG else 15, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
    )
    @given(fields=actuators())
    def put(fields: dict[str, Any]) -> None:
        toml = "\n".join(f"{name} = {written(value)}" for name, value in fields.items())
        answer = operator.put("/api/rig/actuator", json={"toml": toml})
        assert answer.status_code in (202, 422), answer.text
        if answer.status_code == 422:
            assert any(re.search(rf"\b{name}\b", answer.json()["detail"]) for name in (*fields, "dt")), answer.text
        answered[answer.status_code] = answered.get(answer.status_code, 0) + 1

    put()
    assert set(answered) == {202, 422}, answered


def written(value: Any) -> str:
    """As TOML has it, which knows inf and nan."""
    return (
        str(value) if isinstance(value, float) else json.dumps(value).replace("Infinity", "inf").replace("NaN", "nan")
    )


def test_the_page_is_told_when_the_rig_could_not_be_started_with_what_was_chosen(
    server: TestServer, tmp_path: Path
) -> None:
    restarts = tmp_path / "actuator.json"
    server.services.settings.restarts = restarts
    tell_outcome(restarts, ActuatorOutcome(actuator="toppled", reason="no stable rest", in_force="P1"))
    viewer = server.page().sign_in()
    sentence = "actuator toppled did not start: no stable rest; P1 is in force again"

    def failure() -> str:
        time.sleep(0.1)  # asked as fast as a fast machine can it is refused
        return str(viewer.get("/api/rig/actuator").json()["failure"])

    wait_for(lambda: failure() == sentence)
    assert [event.level for event in server.services.events.recent if event.text == sentence] == ["error"]
    tell_outcome(restarts, ActuatorOutcome(actuator="P2", in_force="P2", unkept="Read-only file system"))
    wait_for(lambda: failure() == "")
    assert any("will not have this actuator: Read-only" in event.text for event in server.services.events.recent)


def test_a_rig_that_was_told_to_start_again_is_said_to_start_until_it_is_heard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = OutcomeWatch(ServerSettings(restarts=tmp_path / "actuator.json"), EventLog())
    assert watch.starting(1) == ""
    for reason in ("", "it does not stand still"):
        watch.wait_for("P2", 1)
        watch.look()
        assert [watch.starting(boot) for boot in (1, None, 2)] == ["P2"] * 3, "it is not known yet how that went"
        tell_outcome(tmp_path / "actuator.json", ActuatorOutcome(actuator="P2", reason=reason, in_force="P1"))
        watch.look()
        assert [watch.starting(boot) for boot in (1, None)] == ["P2"] * 2, "the new life is not heard yet"
        assert [watch.starting(boot) for boot in (2, None)] == [""] * 2
    monkeypatch.setattr("server.hardware.outcomes.ACTUATOR_MAX_S", -1.0)
    watch.wait_for("P2", 1)
    assert watch.starting(None) == "", "it takes too long to be called a start"


def test_another_plant_is_ordered_from_rest_only_and_refused_where_the_rig_is_not_ours(
    server: TestServer, tmp_path: Path
) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    server.services.settings.restarts = None
    refused = operator.put("/api/rig/plant", json={"plant": "cosserat"})
    assert (refused.status_code, "--plant where it runs" in refused.text) == (409, True)
    restarts = tmp_path / "actuator.json"
    server.services.settings.restarts = restarts
    assert viewer.put("/api/rig/plant", json={"plant": "cosserat"}).status_code == 403
    assert operator.put("/api/rig/plant", json={"plant": "jelly"}).status_code == 422
    with operator.live() as live:
        live.operate()
        assert operator.command("arm").status_code == 200
        live.wait_mode(Mode.HOLD)
        armed = operator.put("/api/rig/plant", json={"plant": "cosserat"})
        assert (armed.status_code, "disarm first" in armed.text) == (409, True)
        operator.command("e_stop")
        operator.command("clear")
        live.wait_mode(Mode.VENTED)
    assert take_rig(restarts) is None
    assert operator.put("/api/rig/plant", json={"plant": "cosserat"}).status_code == 202
    wanted = take_rig(restarts)
    assert wanted is not None and wanted.twin == TwinParameters(plant="cosserat")
    assert (take_rig(restarts), take_actuator(restarts)) == (None, None)
    for numbers, why in (
        ("kappa=0", "kappa"),
        ("kapa=3", "kapa"),
        ("kappa", "is not like kappa=12"),
        ("rods=2}", "like"),
    ):
        wrong = operator.put("/api/rig/plant", json={"plant": "rod", "numbers": numbers})
        assert (wrong.status_code, why in wrong.text) == (422, True), wrong.text
    given = {"plant": "rod", "numbers": "kappa=12,zeta=0.2,torque_gain=[1.1,1.0]"}
    assert operator.put("/api/rig/plant", json=given).status_code == 202
    wanted = take_rig(restarts)
    assert wanted is not None and wanted.twin == TwinParameters(kappa=12.0, zeta=0.2, torque_gain=(1.1, 1.0))


def test_another_inertia_of_the_observer_is_ordered_from_rest_and_with_another_actuator_it_is_the_tables(
    server: TestServer, tmp_path: Path
) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    given, restarts = {"kappa": 41.5}, tmp_path / "actuator.json"
    server.services.settings.restarts = None
    refused = operator.put("/api/rig/observer-kappa", json=given)
    assert (refused.status_code, "--observer-kappa where it runs" in refused.text) == (409, True)
    server.services.settings.restarts = restarts
    assert viewer.put("/api/rig/observer-kappa", json=given).status_code == 403
    below = operator.put("/api/rig/observer-kappa", json={"kappa": 0.9})
    [fault] = below.json()["detail"]
    assert (below.status_code, fault["loc"], fault["input"], fault["ctx"]) == (422, ["body", "kappa"], 0.9, {"ge": 1.0})
    server.services.settings.rig_file = tmp_path / "arm.toml"
    beside = operator.put("/api/rig/observer-kappa", json=given)
    assert (beside.status_code, "arm.toml" in beside.text) == (409, True)
    server.services.settings.rig_file = None
    assert operator.put("/api/rig/observer-kappa", json=given).status_code == 202
    wanted = take_rig(restarts)
    assert wanted is not None and wanted.controller.observer_kappa == 41.5
    assert with_observer_kappa(wanted, 1.0) == server.services.rig.require_info().parameters
    other = with_other_actuator(wanted, PRESETS["P2"])
    assert (other.actuator, other.controller.observer_kappa) == (PRESETS["P2"], TWIN["kappa"])


def test_an_order_for_a_plant_leaves_the_actuator_and_is_told_by_both_names(tmp_path: Path) -> None:
    class Double:
        settings = RigSettings(parameters=RigParameters(actuator=PRESETS["P2"]))

        def replace(self, parameters: RigParameters) -> None:
            self.settings = self.settings.model_copy(update={"parameters": parameters})

        def started(self) -> Started | None:
            return Started(self.settings.parameters, "")

    path, double = tmp_path / "actuator.json", Double()
    wanted = RigParameters(actuator=PRESETS["P2"], twin=TwinParameters(plant="cosserat"))
    request_rig(path, wanted, Permit(None, lambda request: ""))
    Restarts(path, tmp_path / "kept.json", double).look()  # type: ignore[arg-type]
    assert (double.settings.parameters.actuator.name, double.settings.parameters.twin.plant) == ("P2", "cosserat")
    told = ActuatorOutcome.model_validate_json((tmp_path / "actuator-outcome.json").read_bytes())
    assert (told.actuator, told.reason) == ("P2 as a Cosserat rod", "")
    assert not (tmp_path / "kept.json").exists(), "the next start has the plant that it is told"
