"""The real log of a session as JSON: every line an object, and no secret in any of them."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from server.app.ready import UpReady
from tests.server.live_server import Page, free_environment, wait_for

pytestmark = [pytest.mark.alone, pytest.mark.keyed("server", "controller", "recordings")]

TENDRIL = Path(sys.executable).parent / "tendril"
RIG = f"logs-{os.getpid()}"
FIELDS = {"time", "level", "process", "pid", "logger", "message"}


def session(page: Page, token: str) -> list[str]:
    """What people do, right and wrong; the secrets that they sent or got."""
    page.get("/", params={"token": token})
    cookies = list(page.cookies.values())
    page.post("/api/session", json={"token": "a wrong guess"})
    page.post("/api/session", json={"tokn": token})
    page.post("/api/session", json={"token": [token]})
    page.post("/api/session", content=json.dumps({"token": token})[:-1])
    page.get("/metrics", headers={"authorization": f"Bearer {token}"})
    page.get("/api/rig", headers={"cookie": f"{next(iter(page.cookies))}={cookies[0][:-2]}"})
    page.operate()
    wait_for(lambda: page.get("/api/health").json()["rig_connected"], "the rig")
    page.command("arm")
    page.command("dance")
    with page.live() as live:
        live.send(type="dance")
        live.wait("refused")
    page.command("rest")
    return [token, *cookies, "a wrong guess"]


def test_a_session_leaves_json_lines_without_any_secret(tmp_path: Path) -> None:
    free_environment()
    ready, output, state = tmp_path / "up.json", tmp_path / "log", tmp_path / "state"
    command = [TENDRIL, "up", "--no-browser", "--port", "0", "--rig", RIG, "--log-format", "json"]
    command += ["--ready", ready, "--recordings", tmp_path / "recordings"]
    environment = os.environ | {"XDG_STATE_HOME": str(state), "TENDRIL_LIGHT_SCENE": "1"}
    with output.open("w") as file:
        process = subprocess.Popen(command, env=environment, stdout=file, stderr=subprocess.STDOUT)
        try:
            wait_for(lambda: ready.exists() or process.poll() is not None, "the product")
            started = UpReady.model_validate_json(ready.read_bytes())
            url, token = started.url.split("/?token=")
            with Page(url) as page:
                secrets = session(page, token)
            os.kill(started.rig_process, signal.SIGKILL)
            wait_for(lambda: "restart" in output.read_text(), "the restart in the log")
        finally:
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == 0
    kept = json.loads((state / "tendril" / "secrets.json").read_text())
    secrets += [kept["key"], (state / "tendril" / f"{RIG}.key").read_text().strip()]
    text = output.read_text()
    assert [secret for secret in secrets if secret in text] == []
    lines = [json.loads(line) for line in text.splitlines()]
    assert all(set(line) >= FIELDS for line in lines)
    speakers = {line["process"] for line in lines}
    assert {"rig", "server", "up"} <= speakers <= {"rig", "server", "up", "recorder"}, "the last where it lost rows"
    said = {line["message"]: line for line in lines}
    [restart] = [line for message, line in said.items() if message.endswith("code -9: restart")]
    assert (restart["level"], restart["rig"], restart["code"]) == ("error", RIG, -signal.SIGKILL)
    assert any("dance refused" in message for message in said), "who asked for what is in the log"


def test_a_refused_setting_is_one_json_line_too() -> None:
    done = subprocess.run([TENDRIL, "up", "--port", "99999", "--log-format", "json"], capture_output=True, text=True)
    assert done.returncode == 1
    [line] = done.stderr.splitlines()
    assert json.loads(line)["level"] == "critical" and "port = 99999" in json.loads(line)["message"]
