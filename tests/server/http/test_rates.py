"""How often one client may ask: buckets on a clock of the test's own, then the real server."""

import contextlib
import time

import pytest
from websockets.exceptions import ConnectionClosed

from controller.schema.modes import Mode
from server.http.rates import (
    ANONYMOUS,
    CLIENTS_MAX,
    FLOOD,
    HEAVY,
    MESSAGE,
    POLICY,
    SESSION,
    Bucket,
    Rate,
    Rates,
    Verdict,
)
from tests.server.live_server import VIEWER_TOKEN, TestServer, wait_for

pytestmark = pytest.mark.keyed()


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.t = 1000.0

    def __call__(self) -> float:
        return self.t


def test_a_bucket_gives_its_burst_then_its_rate_and_what_is_refused_costs_nothing() -> None:
    clock = Clock()
    bucket = Bucket(Rate("things", 10, 2), now=clock)
    assert [bucket.wait("a") for _ in range(10)] == [0.0] * 10
    assert [bucket.wait("a") for _ in range(50)] == [pytest.approx(0.5)] * 50
    assert bucket.wait("b") == 0.0, "another client has a bucket of its own"
    clock.t += 0.4
    assert bucket.wait("a") == pytest.approx(0.1)
    clock.t += 0.1
    assert (bucket.wait("a"), bucket.wait("a")) == (0.0, pytest.approx(0.5))
    clock.t += 3600.0
    assert sum(bucket.wait("a") == 0.0 for _ in range(50)) == 10, "an hour of rest saves no more than a burst"


def test_strangers_cannot_fill_the_memory() -> None:
    bucket = Bucket(Rate("things", 1, 1), now=Clock())
    for n in range(3 * CLIENTS_MAX):
        bucket.wait(str(n))
    assert len(bucket._full) <= CLIENTS_MAX


def test_a_page_that_drags_draws_and_plots_for_an_hour_is_never_refused() -> None:
    clock = Clock()
    rates = Rates(now=clock)
    for tick in range(3600 * 6):
        clock.t += 1 / 6
        asked = [False] * (tick % 2) + [True] * 3  # a plan every third of a second, and what is light
        assert [rates.refusal("page", "10.0.0.1", light) for light in asked] == [None] * len(asked)
        verdicts = [rates.message("page") for _ in range((144 + 20 + 1) // 6)]
        assert verdicts == [Verdict.HEARD] * len(verdicts)


@pytest.mark.parametrize(
    ("light", "session", "rate"), [(True, "me", SESSION), (False, "me", HEAVY), (False, None, ANONYMOUS)]
)
def test_each_kind_has_its_own_limit_named_in_the_refusal(light: bool, session: str | None, rate: Rate) -> None:
    rates = Rates(now=Clock())
    found = [rates.refusal(session, "10.0.0.1", light) for _ in range(int(rate.burst) + 1)]
    assert found[:-1] == [None] * int(rate.burst)
    assert (rate.what in str(found[-1]), f"{rate.per_second:g} a second" in str(found[-1])) == (True, True)
    assert rates.refusal("someone else", "10.0.0.1", True) is None


def test_messages_beyond_the_rate_are_dropped_told_once_a_second_and_a_flood_ends() -> None:
    clock = Clock()
    rates = Rates(now=clock)
    verdicts = [rates.message("page") for _ in range(10_000)]
    assert verdicts.count(Verdict.HEARD) == MESSAGE.burst
    assert verdicts.count(Verdict.REFUSED) == 1
    assert verdicts.count(Verdict.DROPPED) == FLOOD.burst - 1
    assert verdicts[-1] == Verdict.FLOOD
    clock.t += 1.0
    assert rates.message("page") == Verdict.HEARD, "and who calms down is heard again"


def test_too_many_requests_get_429_with_the_time_to_wait_but_a_stop_always_passes(server: TestServer) -> None:
    operator = server.operator()
    with operator.live() as live:
        live.operate()
        assert operator.command("arm").status_code == 200
        live.wait_mode(Mode.HOLD)
        _drain(server, operator.get("/api/session").json()["name"])
        refused = operator.get("/api/settings")
        assert (refused.status_code, int(refused.headers["retry-after"]) >= 1) == (429, True)
        assert "requests: more than" in refused.json()["detail"]
        assert "content-security-policy" in refused.headers
        assert operator.command("hold").status_code == 429
        assert operator.command("e_stop").status_code == 200
        live.wait_mode(Mode.E_STOP)
        assert server.page().sign_in().get("/api/settings").status_code == 200, "others are not meant"


def test_stops_without_end_all_reach_the_rig_and_do_not_push_out_what_happened(server: TestServer) -> None:
    viewer = server.page().sign_in(VIEWER_TOKEN)
    before = len(server.services.events.recent)
    assert {viewer.command("e_stop").status_code for _ in range(300)} == {200}
    lines = [event.text for event in server.services.events.recent][before:]
    assert len(lines) < 200
    assert any("more is done than is written here" in line for line in lines)


def test_a_flood_on_the_socket_is_refused_then_ended_and_the_others_are_served(server: TestServer) -> None:
    other, flooding = server.page().sign_in(), server.page().sign_in()
    with other.live() as live, flooding.live() as bad:
        with contextlib.suppress(ConnectionClosed):
            for n in range(20_000):
                bad.send(type="presence", n=n)
        wait_for(lambda: bad.socket.close_code, "the end of the flood")
        assert bad.socket.close_code == POLICY
        said = [m["detail"] for m in bad.texts if m["type"] == "refused"]
        assert said, "it was told before"
        assert all(f"{MESSAGE.per_second:g} a second" in detail for detail in said)
        live.send(type="ping", t=2.5)
        assert live.wait("pong")["t"] == 2.5


def test_refusals_do_not_push_out_what_happened(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    page, now = server.page().sign_in(), time.monotonic()
    monkeypatch.setattr(server.services.events._lines, "_now", lambda: now)  # no token comes back, however slow it is
    before = len(server.services.events.recent)
    for _ in range(200):
        assert page.patch("/api/lease", json={"clutch": True}).status_code == 403
    lines = [event.text for event in server.services.events.recent][before:]
    assert len(lines) < 100
    assert any("more is refused than is written here" in line for line in lines)


def test_a_foreign_page_spends_nothing_of_the_session(server: TestServer, monkeypatch: pytest.MonkeyPatch) -> None:
    page, now = server.page().sign_in(), time.monotonic()
    monkeypatch.setattr(server.services.rates._stranger, "_now", lambda: now)  # no token comes back, however slow it is
    asked = [page.post("/api/lease", headers={"origin": "http://elsewhere"}) for _ in range(int(ANONYMOUS.burst) + 50)]
    assert {answer.status_code for answer in asked} == {403, 429}
    assert page.get("/api/session").status_code == 200


def _drain(server: TestServer, name: str) -> None:
    """Leave the session no tokens for some minutes."""
    full = server.services.rates._session._full
    who = server.services.lease.holder
    assert who is not None
    assert who.name == name
    full[who.id] = full[who.id] + 600.0
