"""The link of a real rig process: unsealed, recorded and malformed messages on an open session, and two servers.

The `stranger` here got past the session, as no one does (test_link_strangers.py): the seals must hold alone.
"""

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import KeyRefused, LayoutMismatch, ParameterError, RigHeld
from controller.link import PlannedRows, RigClient
from controller.link import asker as asker_module
from controller.link.asker import Asker
from controller.link.guard import probe
from controller.link.keys import REPLAY_MAX, Keys, open_session
from controller.link.planned import PLANNED_MAX
from controller.link.seal import SEAL_BYTES, SILENT_S, Introduction
from controller.link.version import OURS
from controller.realtime.ring import HEAD
from controller.realtime.settings import free_port
from controller.schema.layout import to_record
from controller.schema.messages import Command, TwinFaults
from controller.schema.modes import Mode, Request
from controller.schema.parameters import RigParameters, SafetyLimits, Settings
from controller.system.keys import KEY_BYTES, made_key, read_key
from tests.controller.live_rig import LiveRig, Operator, live_rig, wait_for

pytestmark = pytest.mark.alone

KEYS = Keys("test")


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveRig]:
    parameters = RigParameters(limits=SafetyLimits(loop_gap=1.0))
    with live_rig(tmp_path_factory.mktemp("rig"), parameters=parameters) as rig:
        yield rig


@pytest.fixture
def stranger(rig: LiveRig) -> Iterator[Any]:
    """A zenoh session with the rig, in which nothing is sealed unless a test does it."""
    assert rig.settings.key_file
    session = open_session(key=read_key(rig.settings.key_file), connect=rig.ready.endpoint)
    wait_for(lambda: list(session.get(KEYS.info)))
    yield session
    session.close()


def refusal(session: Any, key: str, payload: bytes = b"", seal: bytes | None = None) -> str:
    """What the rig answers to a query that it must refuse."""
    (reply,) = session.get(key, payload=payload, attachment=seal, timeout=5.0)
    assert kind(reply), "it was taken"
    return str(reply.ok.payload.to_string())


def kind(reply: Any) -> str:
    """Of the error that a reply of the rig is, "" if it is none."""
    return bytes(reply.ok.attachment.to_bytes())[24 + 32 :].decode()


def test_without_a_seal_nothing_is_changed(rig: LiveRig, stranger: Any) -> None:
    command = to_record(Command(boot=rig.ready.boot, n=999, request=Request.E_STOP, request_n=999)).tobytes()
    path = np.array([0, 1], np.int64).tobytes() + np.array([0.2, 0.0]).tobytes()
    faults = TwinFaults(sample_loss=1.0).model_dump_json().encode()
    for key, payload in ((KEYS.command, command), (KEYS.reference, path), (KEYS.faults, faults), (KEYS.leave, b"")):
        text = refusal(stranger, key, payload)
        assert "a seal of 0 bytes" in text and str(rig.settings.key_file) in text
        assert "no session" in refusal(stranger, key, payload, bytes(SEAL_BYTES))
    assert len(rig.operator.client.replay(0, 5)) <= 5
    assert rig.operator.client.faults() == TwinFaults()
    row = rig.ring().newest()
    assert row is not None and (row["mode"], row["request_n"]) == (Mode.VENTED, rig.operator.request_n)


def test_with_another_key_no_session_is_opened_and_the_server_says_why(rig: LiveRig, tmp_path: Path) -> None:
    other = RigClient(rig.ready.endpoint, "test", lambda rows: None, key=made_key(tmp_path / "other.key"))
    wait_for(lambda: other.trouble)
    assert f"{rig.ready.endpoint} answers but opens no session: this server's key is not the rig's" in str(
        other.trouble
    )
    with pytest.raises(KeyRefused, match="copy the rig's key file from its machine and name it with --key-file"):
        other.command(Command(request=Request.E_STOP))
    assert not other.connected and other.info is None
    assert rig.operator.send().mode == Mode.VENTED
    other.close()


def test_a_recorded_command_is_refused_when_it_comes_again(rig: LiveRig, stranger: Any) -> None:
    recorded: list[tuple[str, bytes, bytes]] = []

    class Tap:
        """Keeps what passes on the wire."""

        def get(self, key: str, *, payload: bytes, attachment: bytes, **more: Any) -> Any:
            if len(attachment) == SEAL_BYTES:
                recorded.append((key, payload, attachment))
            return stranger.get(key, payload=payload, attachment=attachment, **more)

    rig.operator.client.close()
    assert rig.settings.key_file
    asker = Asker(Tap(), KEYS, read_key(rig.settings.key_file))
    asker.ask_sealed(KEYS.command, to_record(Command(boot=rig.ready.boot)).tobytes())
    asker.ask_sealed(KEYS.faults, TwinFaults(noise=0.001).model_dump_json().encode())
    assert len(recorded) == 3  # the opening, and two messages
    for key, payload, seal in recorded:
        assert refusal(stranger, key, payload, seal)
    (_, command, seal), (_, faults, other_seal) = recorded[1:]
    assert "sealed with another key" in refusal(stranger, KEYS.faults, faults, seal)
    assert "sealed with another key" in refusal(stranger, KEYS.command, command, other_seal)
    asker.ask_sealed(KEYS.faults, TwinFaults().model_dump_json().encode())
    asker.leave(1.0)
    rig.operator = Operator(rig.ready.endpoint, "test", rig.settings.key_file)
    wait_for(lambda: rig.operator.client.connected)


def test_of_two_servers_the_first_commands_and_the_second_only_stops(rig: LiveRig) -> None:
    assert rig.settings.key_file
    first = rig.operator
    second = Operator(rig.ready.endpoint, "test", rig.settings.key_file)
    wait_for(lambda: second.client.connected)
    first.request_n = int(first.newest()["request_n"])
    assert first.send(Request.ARM, settings=Settings(sensed=0b1000000000)).mode == Mode.HOLD
    assert first.send(Request.FOLLOW, target=(0.24, 0.02)).mode == Mode.FOLLOW
    for ask in (
        lambda: second.send(settings=Settings(sensed=1)),
        lambda: second.send(Request.HOLD, request_n=first.request_n + 1),
        lambda: second.client.plan(PlannedRows(np.full((3, 2), 0.2))),
        lambda: second.client.faults(TwinFaults(sample_loss=1.0)),
    ):
        with pytest.raises(RigHeld, match=r"the server on .* \(process \d+\) commands this rig since \d{4}-"):
            ask()
    assert isinstance(second.client.trouble, RigHeld)
    presence = first.newest()["presence"]
    assert first.send(Request.FOLLOW, target=(0.24, 0.03)).mode == Mode.FOLLOW
    stopped = second.send(Request.E_STOP, request_n=first.request_n - 1, presence=10**6)  # it knows an old number
    assert (stopped.accepted, stopped.mode) == (True, Mode.E_STOP)
    row = rig.ring().newest()
    assert row is not None and row["sensed"] in (0, 0b1000000000)
    assert presence <= row["presence"] < 10**6
    unaware = first.send(Request.CLEAR)
    assert not unaware.accepted
    assert f"refused: request {first.request_n} is older than request {stopped.n} of an E-STOP" in unaware.detail
    wait_for(lambda: first.newest()["request_n"] == stopped.n)
    first.request_n = stopped.n
    assert first.send(Request.CLEAR).mode == Mode.VENTED
    second.client.close()


def test_an_e_stop_sent_at_once_acts_and_the_same_one_asked_for_again_is_answered_with_it(rig: LiveRig) -> None:
    first, client = rig.operator, rig.operator.client
    assert first.send(Request.ARM).mode == Mode.HOLD
    wait_for(lambda: first.newest()["mode"] == Mode.HOLD)
    answer = client.send_stop(3, rig.ready.boot, "ann")
    wait_for(lambda: first.newest()["mode"] == Mode.E_STOP)
    taken = int(first.newest()["request_n"])
    assert answer is not None and answer().n == taken
    assert client.stop(3, rig.ready.boot, "ann").n == taken
    assert int(first.newest()["request_n"]) == taken
    first.request_n = taken
    assert first.send(Request.CLEAR).mode == Mode.VENTED


def test_the_second_server_commands_once_the_first_left_or_fell_silent(rig: LiveRig) -> None:
    assert rig.settings.key_file
    first, second = rig.operator, Operator(rig.ready.endpoint, "test", rig.settings.key_file)
    wait_for(lambda: second.client.connected)
    first.send()
    with pytest.raises(RigHeld):
        second.send()

    def taken_over() -> bool:
        try:
            return second.send().accepted
        except RigHeld:
            return False

    wait_for(taken_over, 10 * SILENT_S)
    with pytest.raises(RigHeld):
        first.send()
    second.client.close()
    assert first.send().accepted  # at once: the second one said good-bye


def test_a_server_of_another_layout_is_refused_by_the_rig(
    rig: LiveRig, stranger: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def foreign(who: str) -> Introduction:
        return Introduction(who=who, version="0.0.1", layout="0123456789abcdef")

    monkeypatch.setattr(asker_module, "Introduction", foreign)
    assert rig.settings.key_file
    asker = Asker(stranger, KEYS, read_key(rig.settings.key_file))
    with pytest.raises(LayoutMismatch, match=rf"0\.0\.1 .*0123456789abcdef.*{OURS}.*run the same version"):
        asker.ask_sealed(KEYS.command, to_record(Command(request=Request.ARM, request_n=10**6)).tobytes())
    assert isinstance(asker.trouble, LayoutMismatch)
    assert rig.operator.send().mode == Mode.VENTED


def test_what_is_too_long_or_out_of_bounds_is_refused_by_name(rig: LiveRig, stranger: Any) -> None:
    size = to_record(Command()).itemsize
    assert (
        refusal(stranger, KEYS.command, bytes(size + 1)) == f"payload of {size + 1} bytes is above the limit of {size}"
    )
    assert "above the limit of 48" in refusal(stranger, KEYS.command, bytes(size), bytes(49))
    assert "above the limit of 0" in refusal(stranger, KEYS.info, b"x")
    assert "above the limit of 1024" in refusal(stranger, KEYS.faults, b" " * 2000)
    assert "above the limit of 1024" in refusal(stranger, KEYS.session, b" " * 2000)
    assert f"above the limit of {PLANNED_MAX}" in refusal(stranger, KEYS.reference, bytes(PLANNED_MAX + 16))

    def replay(first: int, count: int) -> str:
        return refusal(stranger, KEYS.replay, np.array([first, count], np.int64).tobytes())

    for count in (0, -1, REPLAY_MAX + 1, 2**62):
        assert replay(0, count) == f"replay: count = {count} is outside [1, {REPLAY_MAX}]"
    assert replay(-5, 10) == "replay: first = -5 is below 0"
    assert list(rig.operator.client.replay(2**63 - 1, 5)) == []
    with pytest.raises(ParameterError, match="sample_loss = 2"):
        asker = Asker(stranger, KEYS, read_key(rig.settings.key_file or Path()))
        asker.ask_sealed(KEYS.faults, b'{"sample_loss": 2.0}')


def test_a_flood_of_strangers_leaves_loop_and_operator_untouched(rig: LiveRig, stranger: Any) -> None:
    ring, operator = rig.ring(), rig.operator
    operator.request_n = int(operator.newest()["request_n"])
    assert operator.send(Request.ARM).mode == Mode.HOLD
    command = to_record(Command(boot=rig.ready.boot, request=Request.E_STOP, request_n=10**6)).tobytes()
    unsealed: bytes | None = None
    flood = [
        (KEYS.command, command, unsealed),
        (KEYS.command, command, bytes(SEAL_BYTES)),
        (KEYS.command, b"short", unsealed),
        (KEYS.faults, b"{" * 900, bytes(SEAL_BYTES)),
        (KEYS.replay, b"\xff" * 16, unsealed),
        (KEYS.session, b"not json", bytes(SEAL_BYTES)),
        (KEYS.reference, bytes(1600), unsealed),
    ]
    head = int(ring.header[HEAD])
    for i in range(0, 10_000, 100):
        asked = [
            stranger.get(key, payload=payload, attachment=seal, timeout=20.0)
            for key, payload, seal in (flood[(i + j) % len(flood)] for j in range(100))
        ]
        for replies in asked:
            assert [bool(kind(reply)) for reply in replies] == [True]
        assert operator.send().mode == Mode.HOLD
    row = ring.newest()
    assert row is not None and (ring.boot, row["mode"]) == (rig.ready.boot, Mode.HOLD)
    wait_for(lambda: ring.head > head + 1000)
    assert row["law"] == Settings().law
    assert operator.client.faults() == TwinFaults()
    assert operator.send(Request.E_STOP).accepted and operator.send(Request.CLEAR).mode == Mode.VENTED


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl here to make certificates with")
def test_with_certificates_the_link_is_encrypted_and_strangers_cannot_read(tmp_path: Path) -> None:
    for folder in ("rig", "server", "stranger"):
        (tmp_path / folder).mkdir()
    certify(tmp_path / "ours", tmp_path / "rig", tmp_path / "server")
    certify(tmp_path / "theirs", tmp_path / "stranger")
    endpoint, key = free_port("tls/127.0.0.1:0"), b"k" * KEY_BYTES
    listening = open_session(key=key, listen=endpoint, tls=tmp_path / "rig")
    queryable = listening.declare_queryable("tendril/test/info", lambda query: query.reply("tendril/test/info", b"me"))
    own = open_session(key=key, connect=endpoint, tls=tmp_path / "server")
    foreign = open_session(key=key, connect=endpoint, tls=tmp_path / "stranger")
    wait_for(lambda: [reply for reply in own.get(KEYS.info) if reply.ok])
    assert list(foreign.get(KEYS.info, timeout=1.0)) == []
    with pytest.raises(ParameterError, match="needs certificates"):
        open_session(key=key, connect=endpoint)
    with pytest.raises(ParameterError, match=r"missing/ca\.pem does not exist"):
        open_session(key=key, connect=endpoint, tls=tmp_path / "missing")
    assert "a certificate is not trusted" in str(probe(endpoint))
    queryable.undeclare()
    for session in (own, foreign, listening):
        session.close()


def certify(authority: Path, *folders: Path) -> None:
    """A certificate authority of our own, and in each folder what it gives to one machine, as the document says."""
    authority.mkdir()
    run(authority, "req -x509 -newkey rsa:2048 -nodes -days 30 -subj /CN=tendril -keyout ca.key -out ca.pem")
    for folder in folders:
        run(folder, f"req -newkey rsa:2048 -nodes -subj /CN={folder.name} -keyout key.pem -out cert.csr")
        (folder / "names.txt").write_text("subjectAltName=IP:127.0.0.1,DNS:localhost\n")
        ca = f"-CA {authority}/ca.pem -CAkey {authority}/ca.key -CAcreateserial"
        run(folder, f"x509 -req -in cert.csr {ca} -days 30 -extfile names.txt -out cert.pem")
        (folder / "ca.pem").write_bytes((authority / "ca.pem").read_bytes())


def run(folder: Path, arguments: str) -> None:
    subprocess.run(["openssl", *arguments.split()], cwd=folder, check=True, capture_output=True)
