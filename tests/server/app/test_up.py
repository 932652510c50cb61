"""`tendril up`: a second one is refused in one sentence, a key that is damaged is made again."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import pytest

from controller.errors import KeyRefused
from controller.realtime.ring import remove_rings
from controller.system.keys import made_key, mended_key, read_key
from server.app.ready import UpReady
from server.app.up import usable_key
from server.recorder import client, folder
from server.rig import planner
from server.settings import ServerSettings
from tests.server.listed import listed
from tests.server.live_server import Page, free_environment, taken, wait_for

pytestmark = [pytest.mark.alone, pytest.mark.keyed("server", "controller", "recordings")]

TENDRIL = Path(sys.executable).parent / "tendril"
RIG = f"up-{os.getpid()}"


def command(folder: Path, rig: str, port: int, ready: Path) -> list[str | Path]:
    given = ["up", "--no-browser", "--rig", rig, "--port", str(port)]
    return [TENDRIL, *given, "--ready", ready, "--recordings", folder / "recordings"]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("up")


@pytest.fixture(scope="module")
def product(home: Path) -> Iterator[UpReady]:
    """One that runs: it takes ten seconds of processor to start and to end."""
    ready = home / "up.json"
    process = subprocess.Popen(command(home, RIG, 0, ready), env=environment(home))
    try:
        wait_for(lambda: ready.exists() or process.poll() is not None, "the product")
        yield UpReady.model_validate_json(ready.read_bytes())
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()
        remove_rings(RIG)


def environment(folder: Path) -> dict[str, str]:
    free_environment()
    return os.environ | {"XDG_STATE_HOME": str(folder / "state"), "TENDRIL_LIGHT_SCENE": "1"}


def started_with(mark: dict[str, str]) -> list[psutil.Process]:
    """Processes with `mark` in their environment: orphans too, who are no one's children here."""

    def is_marked(process: psutil.Process) -> bool:
        try:
            return mark.items() <= process.environ().items()
        except (psutil.NoSuchProcess, psutil.AccessDenied):
            return False

    return [process for process in psutil.process_iter() if is_marked(process)]


def test_a_second_up_says_in_one_sentence_why_not_and_the_first_goes_on(product: UpReady, home: Path) -> None:
    port = urlsplit(product.url).port
    assert port
    wait_for(lambda: children_of(server(product), planner.NAME), "the first one's planner")
    for rig, other_port, why in (
        (RIG, 0, f"rig '{RIG}' already runs on this machine"),
        (f"{RIG}-other", port, f"port = {port}: Address already in use"),
    ):
        mark = {"SECOND_UP": f"{home}-{rig}"}
        done = subprocess.run(
            command(home, rig, other_port, home / "second.json"),
            env=environment(home) | mark,
            capture_output=True,
            text=True,
            timeout=200,
        )
        said = [line for line in done.stderr.splitlines() if " INFO " not in line]
        assert (done.returncode, len(said)) == (1, 1), done.stderr
        assert why in said[0] and "Traceback" not in done.stdout + done.stderr
        assert not (home / "second.json").exists()
        assert not started_with(mark), "nothing is left"
    with Page(product.url.split("/?")[0]) as page:
        page.sign_in(product.url.split("token=")[1])
        wait_for(lambda: page.get("/api/health").json()["rig_connected"], "the rig of the first")
    assert psutil.pid_exists(product.rig_process) and psutil.pid_exists(product.server_process)
    remove_rings(f"{RIG}-other")


@pytest.mark.parametrize("content", [b"", b"half", bytes(45), None])
def test_a_key_of_ours_that_is_none_is_made_anew_and_one_that_was_named_is_left_alone(
    content: bytes | None, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "rig.key"
    if content is None:
        os.mkfifo(path, 0o600)
    else:
        path.touch(0o600)
        path.write_bytes(content)
    for refuse in (made_key, read_key):
        with pytest.raises(KeyRefused, match=str(path)):
            refuse(path)
    with pytest.raises(KeyRefused, match=str(path)):
        usable_key(ServerSettings(rig="rig", state=tmp_path, key_file=path), tmp_path)
    key = mended_key(path)
    assert (len(key), made_key(path), len(caplog.records)) == (32, key, 1)
    assert len([*tmp_path.glob("rig.key.damaged-*")]) == 1


def test_where_the_state_takes_no_file_the_key_holds_for_one_run(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "state").write_text("a file where a folder should be")
    key = usable_key(ServerSettings(rig="rig", state=tmp_path / "state"), tmp_path)
    assert (key, len(read_key(key)), len(caplog.records)) == (tmp_path / "rig.key", 32, 1)


def test_kernels_and_their_compiler_are_in_the_planner_and_not_in_the_server(product: UpReady) -> None:
    with Page(f"http://{urlsplit(product.url).netloc}") as page:
        page.get(product.url)
        circle = {"reference": "circle_1hz"}
        wait_for(lambda: page.post("/api/preview", json=circle).status_code == 200, "a preview")
        assert page.get("/api/workspace").json()["points"]
    (planning,) = children_of(server(product), planner.NAME)
    assert has_compiler(planning)
    assert not any(map(has_compiler, [server(product), *children_of(server(product), folder.NAME)]))


def test_the_server_goes_before_other_programs_where_it_may_and_its_work_after_them(product: UpReady) -> None:
    ask = "import os; from controller.realtime.priority import prefer_process; prefer_process(); print(os.nice(0))"
    allowed = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True).stdout
    assert server(product).nice() == int(allowed)
    working = [one.nice() for name in (planner.NAME, folder.NAME) for one in children_of(server(product), name)]
    assert working and min(working) >= 10


def test_what_writes_and_reads_recordings_is_in_processes_of_their_own_and_not_in_the_server(
    product: UpReady,
) -> None:
    url, token = product.url.split("/?token=")
    with Page(url) as page, page.sign_in(token).operate().live() as live:
        live.operate()
        wait_for(lambda: page.get("/api/health").json()["rig_connected"], "the rig")
        sent = page.post("/api/recordings/import?name=hers", content="t,x,y\n0,0.2,0\n1,0.2,0.01\n")
        assert sent.json()["rows"] == 2
        id = taken(page.post("/api/recordings", json={})).json()["id"]
        wait_for(lambda: listed(page)[0]["rows"], "rows")
        assert page.get(f"/api/recordings/{id}/quick").json()["rows"]
    (writing,) = children_of(server(product), client.WRITING)
    assert "rerun_bindings" in libraries(writing)
    assert not {"rerun_bindings", "libarrow"} & libraries(server(product))


def server(product: UpReady) -> psutil.Process:
    """That of `product`: one that it is just about to start looks like it for a moment."""
    return psutil.Process(product.server_process)


def children_of(process: psutil.Process, program: str) -> list[psutil.Process]:
    """Its children, and theirs, that run this program."""
    return [one for one in process.children(recursive=True) if program in one.cmdline()]


def has_compiler(process: psutil.Process) -> bool:
    return "libllvmlite" in libraries(process)


def libraries(process: psutil.Process) -> set[str]:
    """Names of the files of code that it has in its memory."""
    return {Path(region.path).name.split(".")[0] for region in process.memory_maps()}
