"""Every fenced block of the documents, and a folder with the shipped examples in which their commands run."""

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from controller.system.origin import ROOT
from tests.waiting import wait_for

EXAMPLES = ROOT / "docs" / "examples"
PAGES = [*sorted(ROOT.glob("[A-Z]*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(r"^```(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
STARTS = re.compile(r"tendril (rig|serve|up|virtual-rig)\b")
"""What these start answers until it is stopped."""

NOT_HERE = {
    "make run": "sets everything up again; test_up starts and stops what it runs",
    "make test": "this test is a part of it",
    "scp -p lab@RIG:.tendril/twin.key ~/.tendril/twin.key": "there is no second machine; here both ends share a home",
    "useradd --system tendril-rig; useradd --system tendril-server": "changes the machine's accounts",
    "systemctl daemon-reload; systemctl enable --now tendril-rig": "systemd does not run here",
    "systemctl enable --now tendril-server": "systemd does not run here",
    "install -m 600 -o tendril-server /var/lib/tendril-rig/twin.key -D /var/lib/tendril-server/twin.key": "as above",
    "tendril faults --json faults.json": "test_campaign runs the whole campaign",
    "tendril drivers check labboard --options host=127.0.0.1 --options port=4000": "test_driver_template tries it",
    "tendril drivers check labboard --options host=127.0.0.1 --options port=4000 --record --drive": "as above",
    "tendril drivers check labboard": "as above",
    "python -m tests.e2e.record_live_path --seed 214 --out live.csv": "drags a real Chromium for minutes; made once",
}
"""Commands that no test can run, and why."""
LONG = {
    "tendril calibrate --out fit.toml --seed 0",
    "tendril faults --quick",
    "tendril faults --only rig-killed,link-cut --repeat 3",
    "tendril reproduce --report DIR --json FILE",
    "tendril reproduce --quick",
    "tendril reproduce --quick --law paper",
}
"""Take minutes: `make test-long` has them."""
SMALLER = {"tendril calibrate --out fit.toml --seed 0": "--quick"}
"""Options with which a command of half an hour takes a minute."""


class Block(NamedTuple):
    """One fenced block."""

    page: Path
    kind: str
    text: str


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


def blocks(page: Path) -> list[Block]:
    return [Block(page, *found) for found in FENCE.findall(page.read_text())]


def commands(page: Path) -> list[str]:
    """What the page has its reader type, in order; a Python block is one command."""
    found: list[str] = []
    for block in blocks(page):
        if block.kind == "python":
            found.append(f"python - <<'END'\n{block.text}END")
        elif block.kind == "sh":
            lines = block.text.replace("\\\n", " ").splitlines()
            found += [plain for line in lines if (plain := re.sub(r"(^|\s{2,})#.*$", "", line).strip())]
    return found


def rows_after(page: str, heading: str) -> list[list[str]]:
    """The cells of the first table after `heading`, without its head."""
    table = re.search(r"^\|.*\|\n\|[-|]+\|\n((?:\|.*\|\n)+)", page[page.index(heading) :], re.MULTILINE)
    assert table, heading
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in table[1].splitlines()]


def free_port() -> str:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return str(found.getsockname()[1])


def elsewhere(rig_file: str, folder: Path) -> str:
    """A shipped rig file at addresses that no other test has."""
    return re.sub(r"\b15[01]\d\d\b", lambda _: free_port(), rig_file).replace("/tmp/tendril-board", f"{folder}/board")


class Shell:
    """Runs commands in `folder` as their reader would; `places` are names in the documents that stand for others."""

    def __init__(self, folder: Path, places: dict[str, str], **environment: str) -> None:
        self.folder, self._places = folder, places
        for file in EXAMPLES.iterdir():
            if file.is_file():
                (folder / file.name).write_bytes(file.read_bytes())
        for file in folder.glob("rig*.toml"):
            file.write_text(elsewhere(file.read_text(), folder))
        kept = {key: value for key, value in os.environ.items() if not re.search("^TENDRIL_|^XDG_|_proxy$", key, re.I)}
        self._environment = kept | environment | {
            "HOME": str(folder),
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache"),  # compiled kernels
            "PYTHONPATH": str(ROOT),
        }  # fmt: skip
        (folder / ".curlrc").write_text("fail\n")  # a refusal fails the command
        self._started: list[subprocess.Popen[bytes]] = []

    def run(self, command: str) -> str:
        """What it prints; what starts a rig or a server is left running once it says that it is ready."""
        if started := STARTS.match(command):
            self._start(command, started[1])
            return ""
        done = subprocess.run(
            ["bash", "-euc", self._placed(command)],
            cwd=self.folder, env=self._environment, capture_output=True, text=True, timeout=280,
        )  # fmt: skip
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
        return done.stdout

    def close(self) -> None:
        """Stop what was started, the last one first."""
        codes = {}
        while self._started:
            process = self._started.pop()
            process.send_signal(signal.SIGTERM)
            codes[str(process.args)] = process.wait(60)
        assert not any(codes.values()), codes

    def _start(self, command: str, what: str) -> None:
        ready = self.folder / f"{what}.ready.json"
        more = {
            "rig": f"--ready {ready}",
            "serve": f"--port 0 --ready {ready}",
            "up": f"--port 0 --no-browser --ready {ready}",
            "virtual-rig": f"--out {ready} < /dev/null",  # a rig file, once its wires answer
        }[what]
        line = f"exec {self._placed(command)} {more}"
        process = subprocess.Popen(["bash", "-euc", line], cwd=self.folder, env=self._environment)
        self._started.append(process)
        wait_for(lambda: ready.exists() or process.poll() is not None, command)
        assert process.poll() is None, f"{command} ended with {process.returncode}"

    def _placed(self, command: str) -> str:
        for named, meant in self._places.items():
            command = re.sub(rf"(?<![\w]){re.escape(named)}(?![\w])", meant, command)
        return f"{command} {SMALLER.get(command, '')}".rstrip()
