"""An E-STOP outlives rig and server, with who pressed: the real rig process, killed, and another server."""

from pathlib import Path

import pytest

from controller.schema.modes import Mode
from tests.server.live_server import VIEWER_TOKEN, RigProcess, TestServer, free_environment, key_file, wait_for

pytestmark = pytest.mark.alone


def test_a_stop_outlives_rig_and_server_with_who_pressed(tmp_path: Path) -> None:
    free_environment()
    rig = RigProcess(tmp_path)
    server = TestServer(tmp_path / "first", rig.endpoint, key_file(tmp_path))
    try:
        operator, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
        assert operator.command("arm").status_code == 200
        assert viewer.command("e_stop").status_code == 200
        name = f"{viewer.get('/api/session').json()['name']} (viewer)"
        with operator.live() as live:
            rig.kill()
            rig.start()
            said = live.wait("event", lambda m: "the rig restarted, still in E-STOP" in m["text"])
            assert f"(by {name}) since " in said["text"] and said["level"] == "error"
            wait_for(lambda: live.frames[-1]["mode"] == Mode.E_STOP, "E-STOP")
            refused = operator.command("arm")
            assert refused.status_code == 409 and "clear the E-STOP first" in refused.json()["detail"]
        server.close()
        server = TestServer(tmp_path / "second", rig.endpoint, key_file(tmp_path))
        page = server.page().sign_in().operate()
        with page.live() as live:
            assert live.wait("status", lambda m: m["rig"] and m["stopped_by"])["stopped_by"] == name
            told = [entry.text for entry in server.services.events.recent]
            assert any(f"the rig is connected, still in E-STOP (by {name}) since " in text for text in told)
            assert page.command("clear").status_code == 200
            assert page.command("arm").status_code == 200
        rig.kill()
        rig.start()
        wait_for(lambda: page.get("/api/health").json()["rig_connected"], "the rig")
        assert page.command("arm").status_code == 200  # it was cleared before
    finally:
        server.close()
        rig.kill()
