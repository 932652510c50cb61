"""What a probe and Prometheus are told, read as they read it, and who may ask."""

from pathlib import Path

import httpx
import pytest
from prometheus_client import Metric
from prometheus_client.parser import text_string_to_metric_families

from server.access.gate import Gate, Hosts
from server.access.light import RouteRates
from server.health import healthz
from server.http.rates import WRONG_TOKEN
from tests.server.live_server import TOKEN, TestServer, wait_for


def families(text: str) -> dict[str, Metric]:
    return {family.name: family for family in text_string_to_metric_families(text)}


def value(found: dict[str, Metric], name: str, **labels: str) -> float:
    """The one sample of this family and these labels."""
    [sample] = [sample for sample in found[name].samples if labels.items() <= sample.labels.items()]
    return float(sample.value)


def test_anyone_on_this_machine_may_ask_whether_all_is_well(server: TestServer) -> None:
    wait_for(lambda: server.services.rig.boot(), "the rig")
    answer = server.page().get("/healthz")
    assert (answer.status_code, answer.json()["ok"]) == (200, True), answer.text
    assert {"server", "rig", "recorder", "disk"} < set(answer.json())


async def test_nobody_elsewhere_may(server: TestServer) -> None:
    parts = server.services
    rates = RouteRates(parts.rates, server.app.routes)
    gate = Gate(server.app, parts.sessions, Hosts(parts.settings), rates, parts.audit, parts.refused)
    for host, status in (("192.0.2.7", 401), ("2001:db8::1", 401), ("", 401), ("127.0.0.2", 200), ("::1", 200)):
        strange = httpx.ASGITransport(gate, client=(host, 1234))
        async with httpx.AsyncClient(transport=strange, base_url=server.url) as client:
            wait_for(lambda: server.services.rig.boot(), "the rig")
            assert (await client.get("/healthz")).status_code == status, host


def test_each_part_that_fails_is_named_with_503_and_no_secret(
    server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = server.page()
    wait_for(lambda: server.services.rig.boot(), "the rig")
    monkeypatch.setattr(healthz, "DISK_FREE_MIN", 1 << 60)
    answer = page.get("/healthz")
    assert answer.status_code == 503
    assert not answer.json()["disk"]["ok"] and "MiB are free" in answer.json()["disk"]["detail"]
    assert answer.json()["rig"]["ok"] and answer.json()["recorder"]["ok"]
    server.services.recorder.close()
    answer = page.get("/healthz")
    assert not answer.json()["recorder"]["ok"]
    for secret in (TOKEN, str(server.settings.state), str(server.settings.recordings)):
        assert secret not in answer.text


@pytest.mark.process  # its server reads the recordings in one of its own
def test_a_rig_that_is_not_there_is_unhealthy_and_has_no_loop(tmp_path: Path) -> None:
    server = TestServer(tmp_path, "tcp/127.0.0.1:9")
    try:
        answer = server.page().get("/healthz")
        assert (answer.status_code, answer.json()["rig"]["ok"]) == (503, False)
        found = families(server.page().sign_in().get("/metrics").text)
        assert value(found, "tendril_rig_connected") == 0
        assert "tendril_loop_ticks" not in found
    finally:
        server.close()


def test_prometheus_reads_the_figures_with_the_access_token(server: TestServer) -> None:
    operator = server.operator()
    with operator.live() as live:
        live.send(type="dance")
        live.wait("refused")
        operator.post("/api/command", json={"request": "dance"})
        forger = server.page()
        forger.cookies.set(server.services.sessions.cookie, "WyJpZCIsIm5hbWUiXQ.aaaa.bbbb")
        forger.get("/api/health")
        wait_for(lambda: server.services.loop.health().ticks > 1000, "ticks")
        answer = server.page().get("/metrics", headers={"authorization": f"Bearer {TOKEN}"})
    assert answer.status_code == 200
    found = families(answer.text)
    assert value(found, "tendril_rig_connected") == 1
    assert value(found, "tendril_viewers") == 1
    assert value(found, "tendril_operated") == 1
    assert value(found, "tendril_rig_mode", mode="VENTED") == 1
    assert sum(sample.value for sample in found["tendril_rig_mode"].samples) == 1
    assert value(found, "tendril_loop_ticks") > 1000
    late = [value(found, "tendril_loop_lateness_seconds", quantile=q) for q in ("0.5", "0.99", "1")]
    assert 0.0 < late[0] <= late[1] <= late[2]
    assert 0.0 < value(found, "tendril_link_rtt_seconds") < 60.0
    assert value(found, "tendril_refused_messages") == 1
    assert value(found, "tendril_refused_requests", status="422") == 1
    assert value(found, "tendril_refused_requests", status="401") >= 1
    assert value(found, "tendril_refused_signatures") >= 1
    assert value(found, "tendril_recording_gaps") == 0
    for name in ("process_cpu_seconds", "process_resident_memory_bytes", "process_open_fds"):
        assert value(found, name) > 0


def test_figures_are_for_those_who_know_the_token_and_it_opens_nothing_else(server: TestServer) -> None:
    page = server.page()
    assert page.get("/metrics").status_code == 401
    bearer = {"authorization": f"Bearer {TOKEN}"}
    assert page.get("/api/session", headers=bearer).status_code == 401
    assert page.post("/api/lease", headers=bearer).status_code == 401
    assert page.get("/metrics", headers={"authorization": f"Basic {TOKEN}"}).status_code == 401
    wrong = {"authorization": "Bearer guess"}
    codes = [page.get("/metrics", headers=wrong).status_code for _ in range(int(WRONG_TOKEN.burst))]
    assert codes == [401] * int(WRONG_TOKEN.burst)
    assert page.get("/metrics", headers=bearer).status_code == 200
