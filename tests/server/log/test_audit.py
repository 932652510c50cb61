"""The audit log says who did what, from where, and what came of it."""

import json
import stat
from pathlib import Path
from typing import Any

from server.http.rates import AUDITED
from server.http.who import Identity
from server.log.audit import Asker, Audit, AuditEntry
from server.log.event_file import EventFile
from tests.server.live_server import TOKEN, VIEWER_TOKEN, TestServer, wait_for


def lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def test_every_action_and_refusal_stands_in_the_audit_log_and_no_token(server: TestServer) -> None:
    path = server.settings.state / "audit-test.jsonl"
    viewer, operator = server.page().sign_in(VIEWER_TOKEN), server.operator()
    operator.patch("/api/settings", json={"changes": {"K_P": [0.1, 0.1]}})
    viewer.command("arm")
    viewer.command("e_stop")
    viewer.patch("/api/recordings/nothing", json={})
    server.page().get("/", params={"token": TOKEN})
    server.page().post("/api/session", json={"token": "guessed"})
    with operator.live() as live:
        live.send(type="target", id=1, x=0.1, y=0.1, start=True)
        live.wait("reply")
        live.send(type="target", id=2, x=9, y=0.1)
        live.wait("refused")
    who = viewer.get("/api/session").json()["name"]
    assert server.services.audit.writer.flush(60.0)

    def found(**wanted: Any) -> dict[str, Any] | None:
        fits = (line for line in lines(path) if wanted.items() <= line.items())
        return next(fits, None)

    def said(action: str, status: int, text: str, role: str) -> bool:
        return any(
            (line["action"], line["status"], line["role"]) == (action, status, role) and text in line["detail"]
            for line in lines(path)
        )

    assert found(action="POST /api/command", status=403, name=who, role="viewer", address="127.0.0.1")
    assert said("POST /api/command", 200, f"{who} (viewer): e-stop", "viewer")
    assert said("PATCH /api/settings", 200, "K_P = [0.1, 0.1]", "operator")
    assert said("PATCH /api/recordings/nothing", 403, "viewer's token", "viewer")
    assert said("GET /", 303, "signed in with the operator's token", "")
    assert said("POST /api/session", 401, "wrong access token", "")
    wait_for(lambda: said("WEBSOCKET /ws/live", 101, "follow, target at (0.1000, 0.1000) m", "operator"), "the target")
    wait_for(lambda: said("WEBSOCKET /ws/live", 101, "message refused", "operator"), "the refusal")
    assert TOKEN not in path.read_text()
    assert VIEWER_TOKEN not in path.read_text()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_stranger_cannot_push_others_out_of_the_log(tmp_path: Path) -> None:
    path, clock = tmp_path / "audit.jsonl", [0.0]
    audit = Audit(EventFile(path, AuditEntry), print, lambda: clock[0])
    stranger, other = Asker(None, "1.2.3.4", "GET /x"), Asker(None, "1.2.3.5", "GET /x")
    for _ in range(1000):
        audit.note(stranger, 401)
    audit.note(other, 401)
    audit.note(Asker(Identity("a", "ann", "viewer"), "1.2.3.4", "POST /y"), 403)
    clock[0] = 60.0
    audit.note(stranger, 401)
    assert audit.writer.flush(60.0)
    assert [(line["address"], line["detail"]) for line in lines(path)] == [
        ("1.2.3.4", ""),
        ("1.2.3.5", ""),
        ("1.2.3.4", ""),
        ("1.2.3.4", " (and 999 more since the last line)"),
    ]


def test_a_session_cannot_either_but_for_what_a_page_does_everything_is_there(tmp_path: Path) -> None:
    path, clock = tmp_path / "audit.jsonl", [0.0]
    audit = Audit(EventFile(path, AuditEntry), print, lambda: clock[0])
    ann, bob = (Asker(Identity(name, name, "viewer"), "1.2.3.4", "POST /api/command") for name in ("ann", "bob"))
    for _ in range(10_000):
        audit.note(ann, 200)
    audit.note(bob, 200)
    clock[0] = 60.0
    audit.note(ann, 200)
    assert audit.writer.flush(60.0)
    kept = [(line["name"], line["detail"]) for line in lines(path)]
    assert kept[:-2] == [("ann", "")] * int(AUDITED.burst)
    assert kept[-2:] == [("bob", ""), ("ann", f" (and {10_000 - AUDITED.burst} more since the last line)")]


def test_an_audit_log_that_cannot_be_written_says_so_once(tmp_path: Path) -> None:
    said: list[str] = []
    audit = Audit(EventFile(tmp_path / "nowhere" / "audit.jsonl", AuditEntry), said.append)
    for _ in range(2):
        audit.note(Asker(Identity("a", "ann"), "", "POST /y"), 200)
        assert audit.writer.flush(60.0)
        audit.look()
    assert len(said) == 1
