"""rerun's web viewer, taken out of the installed wheel once, so that our own origin can serve it offline.

The wheel holds it only inside the program. So the program serves it for a moment, to 127.0.0.1 only and on ports that
it chooses itself, and the files are fetched from there.
"""

import atexit
import gzip
import os
import re
import shutil
import subprocess
import tempfile
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path

from controller.errors import RecordingError
from controller.system.child import end_now
from controller.system.thread import in_thread
from controller.system.whole_file import is_regular, set_aside
from recordings.format import tool

FILES = ("index.html", "favicon.ico", "sw.js", "re_viewer.js", "re_viewer_bg.wasm")
GZIPPED = ("re_viewer.js", "re_viewer_bg.wasm")
"""These also lie there as NAME.gz: 43 MB of wasm become 14 MB."""

START_TIMEOUT = 30.0
FETCH_TIMEOUT = 60.0
ADDRESS = re.compile(r"web-viewer at (http://127\.0\.0\.1:\d+)")


def viewer_files(cache: Path | None = None) -> Path:
    """Folder with rerun's web viewer of exactly the installed version, extracted at the first call (about 5 s).

    Raises `RecordingError` when rerun does not serve it in time.
    """
    folder = (cache or cache_folder()) / f"rerun-viewer-{version('rerun-sdk')}"
    if _is_whole(folder):
        return folder
    try:
        _extract(folder)
    except OSError:  # a cache that takes nothing: for this process alone, then
        folder = Path(tempfile.mkdtemp(prefix="tendril-viewer-"), folder.name)
        atexit.register(shutil.rmtree, folder.parent, ignore_errors=True)
        _extract(folder)
    return folder


def cache_folder() -> Path:
    """The user's cache folder of Tendril."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "tendril")


def _is_whole(folder: Path) -> bool:
    names = (*FILES, *(f"{name}.gz" for name in GZIPPED))
    return all(is_regular(folder / name) for name in names)


def _extract(folder: Path) -> None:
    """Fill a temporary folder and rename it: the folder is there whole or not at all, also with two processes at it."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    if os.path.lexists(folder):  # of a process that was killed, or something else by this name
        set_aside(folder)
    draft = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        with _served() as address:
            for name in FILES:
                (draft / name).write_bytes(_fetch(f"{address}/{'' if name == 'index.html' else name}"))
        for name in GZIPPED:
            (draft / f"{name}.gz").write_bytes(gzip.compress((draft / name).read_bytes(), 6, mtime=0))
        draft.chmod(0o755)
        with suppress(OSError):  # another process was first: its files are the same
            draft.rename(folder)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    if not _is_whole(folder):
        raise RecordingError(f"{folder} cannot be written")


@contextmanager
def _served() -> Iterator[str]:
    """Address at which rerun serves its viewer while the context lasts."""
    ports = ("--port", "auto", "--web-viewer-port", "0")
    with tool.quiet_home() as environment:
        process = subprocess.Popen(
            tool.command("--serve-web", "--bind", "127.0.0.1", *ports),
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            yield _address(process)
        finally:
            end_now(process)


def _address(process: "subprocess.Popen[str]") -> str:
    """What rerun prints once it listens; the rest of its output is read away so that it never waits for us."""
    lines: list[str] = []
    found = threading.Event()

    def read() -> None:
        for line in process.stdout or ():
            lines.append(line)
            if ADDRESS.search(line):
                found.set()
        found.set()

    in_thread("rerun output", read)
    found.wait(START_TIMEOUT)
    match = ADDRESS.search("".join(lines))
    if match is None:
        said = "".join(lines).strip()[-400:] or "nothing"
        raise RecordingError(f"rerun did not serve its web viewer within {START_TIMEOUT:g} s; it said: {said}")
    return match[1]


def _fetch(url: str) -> bytes:
    """The body at `url` on this machine, whatever proxy the environment names."""
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    end = time.monotonic() + FETCH_TIMEOUT
    while True:
        try:
            with opener.open(url, timeout=FETCH_TIMEOUT) as answer:
                return bytes(answer.read())
        except OSError as error:
            if time.monotonic() > end:
                raise RecordingError(f"rerun's web viewer did not answer at {url}: {error}") from error
            time.sleep(0.05)
