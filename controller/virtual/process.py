"""A virtual rig in a process of its own, as tests and the fault campaign use it."""

import json
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from controller.errors import TendrilError
from controller.schema.rig_file import changed, parse_rig_file
from controller.system.child import end_now
from controller.virtual.peers import LATENCY

END = 10.0
"""Longest wait for its orderly end [s]."""


class VirtualProcess:
    """Runs from its birth on; `path` then holds the rig file that reaches its devices."""

    def __init__(self, text: str, folder: Path, output: IO[bytes] | None = None) -> None:
        """`text` of a rig file that may leave addresses open; raises TendrilError where it cannot begin."""
        given, self.path = folder / "given.toml", folder / "rig.toml"
        given.write_text(text)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "controller.virtual", str(given)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=output,
            bufsize=0,
            start_new_session=True,
        )
        addresses = self._answer()
        addresses.pop("ready")
        self.path.write_text(changed(text, addresses, str(self.path)))
        self.rig = parse_rig_file(self.path.read_text(), str(self.path))

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    def do(self, line: str) -> None:
        """Break or mend it (`controller.virtual.rig.FAULTS`); raises TendrilError where it refuses."""
        self._ask(line, "done")

    def latency(self) -> float:
        """How old its camera's frames really were when they left, mean of the last second [s]."""
        return float(self._ask(LATENCY, LATENCY))

    def _ask(self, line: str, key: str) -> Any:
        assert self._process.stdin is not None
        self._process.stdin.write(os.fsencode(line) + b"\n")
        answer = self._answer()
        if key not in answer:
            raise TendrilError(f"the virtual rig: {answer.get('refused', answer)}")
        return answer[key]

    def stop(self) -> None:
        """End it, at worst by force."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(END)
        end_now(self._process)

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise TendrilError(f"the virtual rig ended with code {self._process.wait()}; its own output says why")
        found: dict[str, Any] = json.loads(line)
        return found
