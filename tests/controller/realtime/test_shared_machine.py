"""A machine that others use, too: what another user puts in the way stops a start at most, and says whose it is."""

import os
import stat
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from controller.errors import RigUnreachable, TendrilError
from controller.realtime.only_one import only_one
from controller.realtime.ring import Ring, create_ring, find_ring
from controller.realtime.settings import RigSettings
from controller.system import private_folder
from controller.system.private_folder import private_folders

pytestmark = pytest.mark.process

OTHER = 65534
PRECIOUS = "precious data"
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can act as a second user")


def other(command: str) -> subprocess.CompletedProcess[str]:
    """The other user's `sh`."""
    return subprocess.run(
        ["sh", "-c", command], user=OTHER, group=OTHER, extra_groups=(), cwd="/", capture_output=True, text=True
    )


@pytest.fixture
def everyones(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder as /dev/shm is, and the only one that there is: nobody has a session."""
    with tempfile.TemporaryDirectory(dir="/dev/shm", prefix="tendril-test-") as name:
        folder = Path(name)
        folder.chmod(0o1777)
        monkeypatch.setattr(private_folder, "SHARED_MEMORY", folder)
        monkeypatch.setattr(private_folder, "SESSIONS", folder / "no sessions")
        monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
        yield folder


def mode(path: Path) -> int:
    return stat.S_IMODE(path.lstat().st_mode)


def test_ring_and_lock_lie_in_a_folder_of_ours_alone_whatever_the_umask(everyones: Path) -> None:
    before = os.umask(0)
    try:
        ring = create_ring("mine", 1, capacity=8)
        with only_one(RigSettings(rig="mine")):
            pass
    finally:
        os.umask(before)
    folder = everyones / f"tendril-{os.geteuid()}"
    assert ring.path == folder / "tendril-mine.ring"
    assert mode(folder) == 0o700
    assert {file.name: mode(file) for file in folder.iterdir()} == {
        "tendril-mine.ring": 0o600,
        "tendril-mine.lock": 0o600,
    }
    assert find_ring("mine").boot == 1


def test_the_folder_of_the_session_comes_first_where_it_is_private(
    everyones: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = everyones / "session"
    session.mkdir(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(session))
    assert create_ring("mine", 1, capacity=8).path.parent == session / "tendril"
    session.chmod(0o755)
    assert private_folders()[0] == everyones / f"tendril-{os.geteuid()}"


def test_a_rig_of_one_session_is_locked_for_all_others_of_this_user(
    everyones: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Begun over ssh, or while nobody was signed in, it may have its ring elsewhere: the actuator is the same."""
    session, mine = everyones / "session", RigSettings(rig="mine")
    session.mkdir(0o700)
    for first, second in ((str(session), ""), ("", str(session))):
        monkeypatch.setenv("XDG_RUNTIME_DIR", first)
        with only_one(mine):
            monkeypatch.setenv("XDG_RUNTIME_DIR", second)
            with pytest.raises(TendrilError, match="already runs on this machine"), only_one(mine):
                pass
            with only_one(RigSettings(rig="other")):
                pass


def test_a_folder_that_others_may_enter_is_refused_by_name_and_mode(everyones: Path) -> None:
    folder = everyones / f"tendril-{os.geteuid()}"
    folder.mkdir()
    folder.chmod(0o755)
    with pytest.raises(TendrilError, match=rf"{folder} may be entered by others \(mode 0755\).*XDG_RUNTIME_DIR"):
        create_ring("mine", 1, capacity=8)


@as_root
@pytest.mark.parametrize("made", ["mkdir -m 777 {0}", "ln -s {1} {0}", "mkfifo {0}", "touch {0}"])
def test_what_another_user_puts_in_the_place_of_our_folder_is_named_and_not_used(everyones: Path, made: str) -> None:
    folder, precious = everyones / f"tendril-{os.geteuid()}", everyones / "precious"
    precious.mkdir()
    assert other(made.format(folder, precious)).returncode == 0
    with pytest.raises(TendrilError, match=rf"{folder} belongs to .*uid {OTHER}.*remove it"):
        create_ring("mine", 1, capacity=8)
    with (
        pytest.raises(TendrilError, match=rf"{folder} belongs to .*uid {OTHER}"),
        only_one(RigSettings(rig="mine")),
    ):
        pass
    with pytest.raises(RigUnreachable):
        find_ring("mine")
    assert list(precious.iterdir()) == []


@as_root
def test_another_user_can_neither_read_nor_write_nor_add_to_what_is_ours(everyones: Path) -> None:
    ring = create_ring("mine", 1, capacity=8).path
    for command in (f"cat {ring}", f": > {ring}", f"rm {ring}", f"touch {ring}.new", f"ls {ring.parent}"):
        assert "Permission denied" in other(command).stderr
    assert Ring(ring, writable=False).boot == 1


@as_root
@pytest.mark.parametrize("suffix", ["new", "ring", "last"])
@pytest.mark.parametrize("made", ["ln -s {1} {0}", ": > {0}; chmod 666 {0}", "mkfifo -m 666 {0}"])
def test_in_a_folder_of_everyones_what_another_user_made_is_named_and_left(
    everyones: Path, suffix: str, made: str
) -> None:
    """As of a rig that was told to use such a folder."""
    file, precious = everyones / f"tendril-rig.{suffix}", everyones / "precious"
    precious.write_text(PRECIOUS)
    assert other(made.format(file, precious)).returncode == 0
    with pytest.raises(TendrilError, match=rf"{file} belongs to .*uid {OTHER}.*remove it"):
        create_ring("rig", 1, everyones, capacity=8)
    assert precious.read_text() == PRECIOUS


@as_root
def test_a_lock_of_another_user_is_named(everyones: Path) -> None:
    assert other(f": > {everyones}/tendril-rig.lock; chmod 666 {everyones}/tendril-rig.lock").returncode == 0
    with (
        pytest.raises(TendrilError, match=rf"tendril-rig.lock belongs to .*uid {OTHER}.*remove it"),
        only_one(RigSettings(rig="rig", folder=everyones)),
    ):
        pass
