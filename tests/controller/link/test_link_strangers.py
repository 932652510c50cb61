"""Strangers on a real link: in every mode of zenoh without the key, past the session, and in the rig's own place."""

import hmac
import json
import logging
import shutil
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh

from controller.errors import RigUnreachable
from controller.link import RigClient
from controller.link.guard import USER, password
from controller.link.keys import Keys, open_session
from controller.link.seal import SEAL_BYTES
from controller.realtime.settings import free_port
from controller.schema.layout import record_dtype
from controller.schema.messages import Command, Telemetry
from controller.schema.modes import Mode, Request
from controller.system.keys import KEY_BYTES
from tests.controller.fake_rig import KEY, FakeRig
from tests.controller.link.test_link_guarded import certify
from tests.controller.live_rig import wait_for

pytestmark = pytest.mark.alone

KEYS = Keys("fake")
MODES = ("client", "peer", "router")
OTHER = b"o" * KEY_BYTES


class Server:
    """A client of the rig that keeps what it was told."""

    def __init__(self, endpoint: str, tls: Path | None = None) -> None:
        self.ticks: list[int] = []
        self.boots: list[int] = []
        self.client = RigClient(
            endpoint,
            "fake",
            lambda rows: self.ticks.extend(rows["tick"].tolist()),
            lambda info: self.boots.append(info.boot),
            key=KEY,
            tls=tls,
        )


@pytest.fixture
def server(endpoint: str, rig: FakeRig) -> Iterator[Server]:
    server = Server(endpoint)
    wait_for(lambda: (rig.publish(0, 5), server.client.connected)[1])
    yield server
    server.client.close()


def session(mode: str, secret: str = "", **ends: str) -> Any:
    """A session of zenoh as anyone opens it; ZError where a client is not let in at once."""
    settings: dict[str, Any] = {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": mode == "router",
        "connect/timeout_ms": 1000,
        "connect/exit_on_failure": mode == "client",
        "connect/endpoints": [],
        "listen/endpoints": [],
    }
    settings |= {f"{end}/endpoints": [place] for end, place in ends.items()}
    if secret:
        settings["transport/auth/usrpwd"] = {"user": USER, "password": secret}
    config = zenoh.Config()
    for name, value in settings.items():
        config.insert_json5(name, json.dumps(value))
    return zenoh.open(config)


def impostor(endpoint: str, rig: "Impersonation") -> Any:
    """A session in the rig's place, to which servers with the key connect: it says whatever it likes."""
    listening = open_session(key=KEY, listen=endpoint)
    rig.declare(listening)
    return listening


class Impersonation:
    """Answers every key of the rig, and keeps what it was asked."""

    def __init__(self, silent: bool = False) -> None:
        self.asked: list[str] = []
        self.kept: list[Any] = []
        self.reply, self.attachment = b'{"n": 1, "accepted": true, "mode": 0, "cause": 0, "detail": "VENTED"}', b""
        self.silent = silent

    def declare(self, at: Any) -> None:
        for key in (KEYS.command, KEYS.info, KEYS.session, KEYS.replay):
            at.declare_queryable(key, self._answer, complete=True)
        at.liveliness().declare_token(KEYS.alive("1"))

    def _answer(self, query: Any) -> None:
        self.asked.append(str(query.key_expr))
        if self.silent:
            self.kept.append(query)
            return
        with query:
            query.reply(query.key_expr, self.reply, attachment=self.attachment or bytes(24 + 32))


def rows(first: int, end: int) -> np.ndarray:
    found = np.zeros(end - first, record_dtype(Telemetry))
    found["tick"] = np.arange(first, end)
    return found


FORGED = rows(60_000, 60_010).tobytes()


def attack(stranger: Any, boot: int) -> Impersonation:
    """Everything that a stranger can send, once; what it was asked in the rig's place."""
    for attachment in (boot.to_bytes(8, "little"), bytes(48), None):
        stranger.put(KEYS.telemetry, FORGED, attachment=attachment)
    stranger.put("tendril/fake/**", FORGED)
    stranger.delete(KEYS.telemetry)
    place = Impersonation()
    place.declare(stranger)
    stranger.liveliness().declare_token(KEYS.alive("2"))
    return place


@pytest.mark.parametrize("mode", MODES)
def test_a_stranger_opens_no_session_in_any_mode(mode: str, endpoint: str, rig: FakeRig, server: Server) -> None:
    for secret in ("", password(OTHER)):
        try:
            stranger = session(mode, secret, connect=endpoint)
        except zenoh.ZError:
            assert mode == "client"
            continue
        assert list(stranger.get(KEYS.info, timeout=0.3)) == []
        heard: list[bytes] = []
        stranger.declare_subscriber(
            "tendril/fake/**", lambda sample, heard=heard: heard.append(sample.payload.to_bytes())
        )
        place = attack(stranger, rig.boot)
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            rig.publish(5, 10)
            assert server.client.command(Command(n=7)).n == 7
        assert set(heard) <= {FORGED, b""} and not place.asked  # it hears itself, and no one else
        assert [*stranger.info.peers_zid(), *stranger.info.routers_zid()] == []
        stranger.close()
    wait_for(lambda: (rig.publish(5, 10), server.ticks[-1:] == [9])[1])
    assert server.ticks == list(range(server.ticks[0], 10))
    assert server.client._refusals.count == 0


@pytest.mark.parametrize("mode", MODES)
def test_who_got_past_the_session_can_neither_publish_nor_answer(
    mode: str, endpoint: str, rig: FakeRig, server: Server
) -> None:
    insider, own = session(mode, password(KEY), connect=endpoint), rig.boot
    wait_for(lambda: [*insider.info.peers_zid(), *insider.info.routers_zid()])
    heard: list[Any] = []
    insider.declare_subscriber(KEYS.telemetry, heard.append)
    wait_for(lambda: (rig.publish(5, 10), heard)[1])  # its session works: it hears the rig
    place = attack(insider, own)
    for _ in range(20):
        reply = server.client.command(Command(n=7, request=Request.E_STOP))
        assert (reply.accepted, reply.mode) == (True, Mode.E_STOP)
        rig.publish(10, 15)
    wait_for(lambda: server.ticks[-1:] == [14])
    assert server.ticks == list(range(15))
    assert not place.asked
    assert server.client._refusals.count == 0
    assert server.client.connected
    insider.close()


def test_the_session_password_makes_neither_seals_nor_proofs() -> None:
    assert password(KEY) != password(OTHER)
    assert bytes.fromhex(password(KEY)) == hmac.digest(KEY, b"tendril session 1", "sha256")
    assert len(password(KEY)) == 64


def test_an_impostor_in_the_rigs_place_is_believed_nothing(endpoint: str, caplog: pytest.LogCaptureFixture) -> None:
    place = Impersonation()
    false = impostor(endpoint, place)
    server = Server(endpoint)
    caplog.set_level(logging.WARNING)
    proofs: list[Any] = [None, b"", (1).to_bytes(8, "little"), bytes(48), bytes(56), bytes(5000)]
    telling = rows(0, 10).tobytes()
    for payload in (telling, telling[:-1], b"", b"not rows"):
        for proof in proofs:
            wait_for(lambda: [*false.info.peers_zid()])
            before = server.client._refusals.count
            wait_for(
                lambda payload=payload, proof=proof, before=before: (
                    false.put(KEYS.telemetry, payload, attachment=proof),
                    server.client._refusals.count > before,
                )[1]
            )
    with pytest.raises(RigUnreachable, match=r"did not answer within .*; 1 replies did not bear the proof of its key"):
        server.client.command(Command(request=Request.E_STOP))
    assert place.asked == [KEYS.session]  # nothing sealed is sent before the rig has proven itself
    assert not server.client.connected and server.client.info is None
    assert server.ticks == server.boots == []
    lines = [record for record in caplog.records if record.name == "controller.link.refusals"]
    assert len(lines) == 2 and not any(record.exc_info for record in caplog.records)
    assert {record.getMessage().split(": ")[0] for record in lines} == {
        f"rig fake, batch on {KEYS.telemetry}",
        f"rig fake, reply on {KEYS.session}",
    }
    server.client.close()
    false.close()


class Tap:
    """Keeps what a rig publishes."""

    def __init__(self, publisher: Any, told: list[tuple[bytes, bytes]]) -> None:
        self._publisher, self._told = publisher, told

    def put(self, payload: bytes, attachment: bytes) -> None:
        self._told.append((payload, attachment))
        self._publisher.put(payload, attachment=attachment)

    def undeclare(self) -> None:
        self._publisher.undeclare()


def recorded(endpoint: str, boot: int, server: Server) -> tuple[list[tuple[bytes, bytes]], tuple[bytes, bytes]]:
    """Batches, and an answer to who it is, of a boot of the rig that `server` meets and that is over then."""
    told: list[tuple[bytes, bytes]] = []
    rig = FakeRig(endpoint, boot)
    rig.end._publisher = Tap(rig.end._publisher, told)
    firsts = iter(range(0, 20_000, 5))

    def met() -> bool:
        first = next(firsts)
        rig.publish(first, first + 5)
        return server.client.connected and boot in server.boots

    wait_for(met)
    eavesdropper = open_session(key=KEY, connect=endpoint)
    wait_for(lambda: list(eavesdropper.get(KEYS.info)))
    (reply,) = eavesdropper.get(KEYS.info, attachment=bytes(16))
    eavesdropper.close()
    rig.close()
    wait_for(lambda: not server.client.connected)
    return told, (reply.ok.payload.to_bytes(), reply.ok.attachment.to_bytes())


def test_a_rig_that_lets_everybody_in_is_not_taken_for_ours(endpoint: str) -> None:
    """Any zenoh, or a rig of a version in which sessions needed no key."""
    anybody = session("peer", listen=endpoint)
    server = Server(endpoint)
    wait_for(lambda: server.client.trouble)
    assert "answers but opens no session" in str(server.client.trouble)
    assert "or the rig is of another version of Tendril" in str(server.client.trouble)
    assert not server.client.connected
    server.client.close()
    anybody.close()


def test_what_was_recorded_of_the_rig_is_worth_nothing_later(endpoint: str) -> None:
    """Batches and replies of this boot and of an earlier one, sent again by who took the rig's place."""
    server = Server(endpoint)
    lives = [recorded(endpoint, boot, server) for boot in (1, 2)]
    fresh = Server(endpoint)
    ticks, age = list(server.ticks), server.client.age()
    for told, (reply, attachment) in lives:
        place = Impersonation()
        place.reply, place.attachment = reply, attachment
        false = impostor(endpoint, place)
        wait_for(lambda false=false: len(false.info.peers_zid()) == 2)
        before = fresh.client._asker._refusals.count
        for payload, proof in told * 3:
            false.put(KEYS.telemetry, payload, attachment=proof)
        wait_for(lambda before=before: fresh.client._asker._refusals.count > before)  # it asked who that is
        assert KEYS.info in place.asked
        assert not server.client.connected and not fresh.client.connected
        false.close()
    assert server.client._refusals.count > 0  # batches of the boot that it knew
    assert server.ticks == ticks and fresh.ticks == [] and fresh.client.info is None
    assert server.client.age() > age
    for one in (server, fresh):
        one.client.close()


def test_rows_that_jump_are_refused_once_and_the_stream_goes_on(
    rig: FakeRig, server: Server, caplog: pytest.LogCaptureFixture
) -> None:
    rig.publish(5, 10)
    wait_for(lambda: server.ticks[-1:] == [9])
    rig.end.publish(rows(60_000, 60_010))
    late = rows(10, 15)
    late["t_ns"] = time.monotonic_ns() + 60_000_000_000
    wait_for(lambda: server.client._refusals.count == 1)
    wait_for(lambda: (rig.publish(10, 15), server.ticks[-1:] == [14])[1])
    late["tick"] += 5
    rig.end.publish(late)
    wait_for(lambda: server.client._refusals.count == 2)
    disordered = rows(20, 25)
    disordered["tick"][3] = 22
    wait_for(lambda: (rig.publish(15, 20), server.ticks[-1:] == [19])[1])
    rig.end.publish(disordered)
    wait_for(lambda: server.client._refusals.count == 3)
    wait_for(lambda: (rig.publish(20, 25), server.ticks[-1:] == [24])[1])
    assert server.ticks == list(range(25)) and server.client.gaps == 0
    lines = [record.getMessage() for record in caplog.records if "refused" in record.getMessage()]
    assert len(lines) == 1 and "tick went 60.0 s ahead in" in lines[0]
    assert not any(record.exc_info for record in caplog.records)


def test_a_row_of_another_size_is_one_line(rig: FakeRig, server: Server, caplog: pytest.LogCaptureFixture) -> None:
    payload = bytes(record_dtype(Telemetry).itemsize + 1)

    def sent_and_refused() -> int:
        """A batch may be dropped where the machine is busy, so there is one more at each look."""
        rig.end._publisher.put(payload, attachment=rig.end._prover.batch(KEYS.telemetry, payload))
        return server.client._refusals.count

    wait_for(lambda: sent_and_refused() >= 3)
    lines = [record for record in caplog.records if "are not rows of" in record.getMessage()]
    assert len(lines) == 1 and not lines[0].exc_info


@pytest.mark.parametrize("protocol", ["tcp", "tls"])
def test_connections_that_say_nothing_keep_no_server_out(protocol: str, tmp_path: Path) -> None:
    tls = None
    if protocol == "tls":
        if shutil.which("openssl") is None:
            pytest.skip("no openssl here to make certificates with")
        tls = tmp_path / "tls"
        tls.mkdir()
        certify(tmp_path / "authority", tls)
    endpoint = free_port(f"{protocol}/127.0.0.1:0")
    rig = FakeRig(endpoint, 1, tls=tls)
    with idle(endpoint, 300):
        server = Server(endpoint, tls)
        wait_for(lambda: (rig.publish(0, 5), server.client.connected)[1])
        server.client.close()
    rig.close()


@contextmanager
def idle(endpoint: str, count: int) -> Iterator[None]:
    """So many connections that say nothing; whatever the rig closes is opened again."""
    host, port = endpoint.split("/")[1].split(":")
    lines, over = [socket.create_connection((host, int(port))) for _ in range(count)], threading.Event()

    def hold() -> None:
        while not over.wait(0.01):
            for place, line in enumerate(lines):
                line.setblocking(False)
                try:
                    closed = not line.recv(1)
                except BlockingIOError:
                    closed = False
                except OSError:
                    closed = True
                if closed:
                    line.close()
                    lines[place] = socket.create_connection((host, int(port)))

    holding = threading.Thread(target=hold)
    holding.start()
    try:
        yield
    finally:
        over.set()
        holding.join()
        for line in lines:
            line.close()


def test_questions_bear_something_that_none_before_did(rig: FakeRig, server: Server) -> None:
    seen: list[bytes] = []
    link = server.client._asker._link

    class Tap:
        def get(self, key: str, *, attachment: bytes, **more: Any) -> Any:
            seen.append(attachment)
            return link.get(key, attachment=attachment, **more)

    server.client._asker._link = Tap()
    for _ in range(3):
        server.client.replay(0, 1)
        server.client.faults()
        server.client.command(Command())
    assert len(set(seen)) == len(seen) >= 9
    assert {len(attachment) for attachment in seen} == {16, SEAL_BYTES}
    server.client._asker._link = link
