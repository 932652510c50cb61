"""Token, cookie and lease."""

import stat
import time
from pathlib import Path

import pytest
from pydantic import SecretStr

from controller.errors import ParameterError
from controller.schema.parameters import Settings
from controller.system.keys import key_path
from controller.system.whole_file import write_whole
from server.access import lease as leases
from server.access.lease import OperatorLease
from server.access.sessions import MAX_AGE, Sessions, TooManyAttempts, WrongToken, same_origin
from server.access.token_watch import CLOSED_AFTER, TokenWatch
from server.access.tokens import Secrets, TokenFile, load_secrets
from server.http.rates import SIGN_IN, WRONG_TOKEN, Rates
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.settings import FIRST, KeptSettings
from server.settings import ServerSettings, exposed


class Clock:
    """A clock that stands until it is moved."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


def sessions(token: str = "right", clock: Clock | None = None) -> Sessions:
    kept = Secrets(token=token, viewer_token="look", key="k" * 20)
    return Sessions(kept, "tendril_rig_1", rates=Rates(now=clock or Clock()))


def test_cookie_is_read_back_and_a_forged_or_foreign_one_is_not() -> None:
    ours = sessions()
    who = ours.open("right", "here")
    sealed = ours.seal(who)
    assert ours.read({ours.cookie: sealed}) == who
    assert ours.read({ours.cookie: sealed[:-2] + "xx"}) is None
    assert ours.read({ours.cookie: '["id","name"]'}) is None
    assert ours.read({}) is None
    assert sessions("another token").read({ours.cookie: sealed}) is None, "a new token ends old sessions"


def test_a_cookie_lapses_after_a_week_but_not_because_the_wall_clock_was_set_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ours, now = sessions(), time.time()
    who = ours.open("right", "here")
    sealed = ours.seal(who)
    for step, found in ((-3600.0, who), (MAX_AGE - 60.0, who), (MAX_AGE + 60.0, None), (-MAX_AGE - 60.0, None)):
        monkeypatch.setattr(time, "time", lambda step=step: now + step)
        assert ours.read({ours.cookie: sealed}) == found, step


def test_wrong_tokens_are_refused_as_too_many_and_a_right_one_from_the_same_address_never_is() -> None:
    clock = Clock()
    ours = sessions(clock=clock)
    for _ in range(int(WRONG_TOKEN.burst)):
        with pytest.raises(WrongToken):
            ours.open("wrong", "proxy")
    for _ in range(1000):
        with pytest.raises(TooManyAttempts) as late:
            ours.open("wrong", "proxy")
    assert late.value.wait == pytest.approx(1 / WRONG_TOKEN.per_second)
    assert (ours.open("right", "proxy").role, ours.require("look", "proxy")) == ("operator", "viewer")
    with pytest.raises(WrongToken):
        ours.open("wrong", "someone else")
    clock.now = late.value.wait + 1e-6
    with pytest.raises(WrongToken):
        ours.open("wrong", "proxy")


def test_sessions_that_are_opened_without_end_share_one_budget_and_leave_that_of_the_other_role() -> None:
    ours = sessions()
    many = [ours.open("look", "proxy") for _ in range(int(SIGN_IN.burst) + 50)]
    assert len({who.id for who in many}) == len(many)
    assert len({who.client for who in many}) == SIGN_IN.burst + 1
    kept = ours.read({ours.cookie: ours.seal(many[-1])})
    assert kept is not None and kept.client == many[-2].client != kept.id, "a cookie holds it"
    assert not ours.open("right", "proxy").budget and not ours.open("look", "elsewhere").budget


def test_token_is_kept_and_readable_by_the_user_alone(tmp_path: Path) -> None:
    first = load_secrets(ServerSettings(state=tmp_path / "state"))
    assert load_secrets(ServerSettings(state=tmp_path / "state")) == first
    assert stat.S_IMODE((tmp_path / "state" / "secrets.json").stat().st_mode) == 0o600
    given = load_secrets(ServerSettings(state=tmp_path / "state", token=SecretStr("mine")))
    assert (given.token, given.key) == ("mine", first.key)


def test_an_old_file_with_one_token_is_the_operators_and_gets_a_viewers(tmp_path: Path) -> None:
    write_whole(tmp_path / "secrets.json", '{"token": "old", "key": "kkk"}')
    found = load_secrets(ServerSettings(state=tmp_path))
    assert (found.token, found.key) == ("old", "kkk")
    assert len(found.viewer_token) > 20
    assert load_secrets(ServerSettings(state=tmp_path)) == found
    with pytest.raises(ParameterError, match="are the same"):
        load_secrets(ServerSettings(state=tmp_path, viewer_token=SecretStr("old")))
    (tmp_path / "secrets.json").chmod(0o644)
    with pytest.raises(ParameterError, match="has mode 0644"):
        load_secrets(ServerSettings(state=tmp_path))


def test_a_changed_token_ends_only_the_sessions_that_it_opened(tmp_path: Path) -> None:
    file = TokenFile(ServerSettings(state=tmp_path))
    kept = file.made()
    ours = Sessions(kept, "tendril_rig_1")
    operator, viewer = ours.open(kept.token, "here"), ours.open(kept.viewer_token, "here")
    assert (operator.role, viewer.role) == ("operator", "viewer")
    cookies = [{ours.cookie: ours.seal(who)} for who in (operator, viewer)]
    assert [ours.read(cookie) for cookie in cookies] == [operator, viewer]
    clock = Clock()
    lease, log = OperatorLease(), EventLog()
    watch = TokenWatch(file, ours, kept, lease, log, clock)
    assert lease.acquire(operator)
    away = (tmp_path / "secrets.json").rename(tmp_path / "away")
    clock.now = 1.0
    watch.poll()
    watch.look()
    assert [ours.read(cookie) for cookie in cookies] == [operator, viewer], "a folder that went away signs no one out"
    away.rename(tmp_path / "secrets.json")
    token = file.renew("viewer")
    clock.now = 2.0
    watch.poll()
    watch.look()
    assert [ours.read(cookie) for cookie in cookies] == [operator, None]
    assert (ours.stands(operator), ours.stands(viewer), lease.holds(operator)) == (True, False, True)
    assert ours.open(token, "here").role == "viewer"
    file.renew("operator")
    clock.now = 4.0
    watch.poll()
    watch.look()
    assert (ours.read(cookies[0]), lease.holder) == (None, None)
    assert len(log.recent) == 2
    assert stat.S_IMODE((tmp_path / "secrets.json").stat().st_mode) == 0o600


@pytest.mark.parametrize("content", [b"", b"{", b'{"token": "x"}', b"\xff\xfe\x00"])
def test_damaged_files_of_the_state_folder_are_named_and_put_aside(
    content: bytes, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    settings = ServerSettings(state=tmp_path, rig="test")
    for name in ("secrets.json", "settings-test.json"):
        (tmp_path / name).write_bytes(content)
    found = load_secrets(settings)
    assert load_secrets(settings) == found, "the new tokens are kept"
    [aside] = tmp_path.glob("secrets.json.damaged-*")
    assert (aside.read_bytes(), str(aside) in caplog.text) == (content, True)
    kept = KeptSettings(tmp_path / "settings-test.json", EventLog())
    assert kept.read() == kept.read() == Settings().model_copy(update=FIRST)
    assert len(caplog.records) == 2, "one line for each file, however often it is read"


def test_a_running_server_keeps_its_tokens_while_their_file_is_damaged(tmp_path: Path) -> None:
    file = TokenFile(ServerSettings(state=tmp_path))
    kept = file.made()
    (tmp_path / "secrets.json").write_text("{")
    log, clock = EventLog(), Clock()
    watch = TokenWatch(file, Sessions(kept, "tendril_rig_1"), kept, OperatorLease(), log, clock)
    (tmp_path / "secrets.json").write_text('{"tok')
    clock.now = 1.0
    watch.poll()
    watch.look()
    assert [(event.level, "stay as they were" in event.text) for event in log.recent] == [("warning", True)]
    assert [*tmp_path.iterdir()] == [tmp_path / "secrets.json"], "nothing is put aside under a running server"


def test_a_token_whose_file_could_not_be_read_once_is_revoked_all_the_same(tmp_path: Path) -> None:
    file, path = TokenFile(ServerSettings(state=tmp_path)), tmp_path / "secrets.json"
    kept = file.made()
    ours, lease, log, clock = Sessions(kept, "tendril_rig_1"), OperatorLease(), EventLog(), Clock()
    watch, operator = TokenWatch(file, ours, kept, lease, log, clock), ours.open(kept.token, "here")
    cookie = {ours.cookie: ours.seal(operator)}
    assert lease.acquire(operator)
    file.renew("operator")
    path.chmod(0o644)  # the file is refused, and its time of change stays as it is
    watch.poll()
    watch.look()
    assert ours.stands(operator) and lease.holds(operator)
    path.chmod(0o600)
    watch.poll()
    watch.look()
    assert ours.read(cookie) is None and lease.holder is None


def test_while_the_tokens_cannot_be_read_nobody_operates_and_everybody_may_look(tmp_path: Path) -> None:
    file, path = TokenFile(ServerSettings(state=tmp_path)), tmp_path / "secrets.json"
    kept = file.made()
    ours, lease, log, clock = Sessions(kept, "tendril_rig_1"), OperatorLease(), EventLog(), Clock()
    watch, operator = TokenWatch(file, ours, kept, lease, log, clock), ours.open(kept.token, "here")
    cookie, whole = {ours.cookie: ours.seal(operator)}, path.read_text()
    assert lease.acquire(operator)
    path.write_text('{"tok')
    for clock.now in (0.0, CLOSED_AFTER - 0.1):
        watch.poll()
        watch.look()
        assert lease.holds(operator)
    clock.now = CLOSED_AFTER
    watch.look()
    shown = ours.read(cookie)
    assert shown is not None and (shown.id, shown.role, lease.holder) == (operator.id, "viewer", None)
    assert ours.stands(shown) and not ours.stands(operator)
    assert ours.open(kept.token, "here").role == "viewer"
    path.write_text(whole)
    watch.poll()
    watch.look()
    assert ours.read(cookie) == operator and ours.stands(operator)
    assert [event.level for event in log.recent] == ["warning", "error", "warning"]


def test_only_loopback_is_not_exposed() -> None:
    assert [exposed(host) for host in ("127.0.0.1", "::1", "localhost")] == [False] * 3
    assert [exposed(host) for host in ("0.0.0.0", "::", "192.168.1.4", "lab.example")] == [True] * 4


def test_only_our_own_page_or_no_page_is_the_same_origin() -> None:
    assert same_origin({"host": "rig:8321"})
    assert same_origin({"host": "rig:8321", "origin": "http://rig:8321"})
    malformed = ("http://[", "http://[::1]rig:8321", "//[rig:8321]")
    for origin in ("null", "", "http://rig:9999", "http://evil.example", "https://rig:8321.evil.example", *malformed):
        assert not same_origin({"host": "rig:8321", "origin": origin}), origin


def test_one_session_operates_until_it_releases_or_falls_silent() -> None:
    clock = Clock()
    lease = OperatorLease(clock)
    ann, bob = Identity("a", "ann"), Identity("b", "bob")
    assert lease.acquire(ann)
    assert lease.acquire(ann)
    assert not lease.acquire(bob)
    assert lease.view(bob).model_dump() == {"held": True, "mine": False, "holder": "ann", "clutch": False, "lost": ""}
    clock.now = leases.LAPSE_S
    lease.touch(bob)
    lease.touch(ann)
    clock.now = 2 * leases.LAPSE_S
    assert lease.holds(ann)
    assert not lease.release(bob)
    clock.now += 0.1
    assert lease.holder is None, "silence ends it"
    assert lease.acquire(bob)
    assert lease.release(bob)
    assert not lease.view(bob).held


def test_rig_and_server_look_for_the_key_in_the_same_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TENDRIL_STATE", str(tmp_path))
    assert key_path("lab") == ServerSettings(rig="lab").key == tmp_path / "lab.key"
    monkeypatch.delenv("TENDRIL_STATE")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert key_path("lab") == ServerSettings(rig="lab").key == tmp_path / "tendril" / "lab.key"
