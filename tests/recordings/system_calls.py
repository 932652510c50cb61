"""Records, in their order, the system calls by which a program and its children change the files of a folder.

By seccomp's notifications (Linux 5.5): no root, no package and no debugger, and rerun's own threads and programs are
seen as well. A call is noted when it is made. An fsync in the folder is answered at once, without the disk: so it has
ended when it is noted.
"""

import ctypes
import fcntl
import os
import platform
import runpy
import select
import socket
import struct
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

NUMBERS = {
    "x86_64": {
        "write": 1, "pwrite64": 18, "writev": 20, "sendfile": 40, "fsync": 74, "fdatasync": 75, "truncate": 76,
        "ftruncate": 77, "rename": 82, "mkdir": 83, "rmdir": 84, "creat": 85, "link": 86, "unlink": 87, "symlink": 88,
        "openat": 257, "mkdirat": 258, "unlinkat": 263, "renameat": 264, "linkat": 265, "fallocate": 285,
        "pwritev": 296, "renameat2": 316, "copy_file_range": 326, "pwritev2": 328,
    },
    "aarch64": {
        "write": 64, "pwrite64": 68, "writev": 66, "sendfile": 71, "fsync": 82, "fdatasync": 83, "truncate": 45,
        "ftruncate": 46, "openat": 56, "mkdirat": 34, "unlinkat": 35, "renameat": 38, "linkat": 37, "fallocate": 47,
        "pwritev": 70, "renameat2": 276, "copy_file_range": 285, "pwritev2": 287,
    },
}  # fmt: skip
ARCHES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
SECCOMP = {"x86_64": 317, "aarch64": 277}
RECEIVE, SEND, GO_ON = 0xC0502100, 0xC0182101, 1
NOTICE, ANSWER = struct.Struct("<QIIiIQ6Q"), struct.Struct("<QqiI")
AT_FDCWD, AT_REMOVEDIR = -100, 0x200
O_CREAT, O_TRUNC, O_EXCL = os.O_CREAT, os.O_TRUNC, os.O_EXCL


@dataclass(frozen=True)
class Call:
    """One call; paths are relative to the folder. `name` is write, truncate, create, rename, link, remove, mkdir,
    sync or said (a line on standard output).
    """

    thread: int
    at: float
    name: str
    path: str = ""
    to: str = ""
    offset: int = 0
    data: bytes = b""


@dataclass
class Recorded:
    """What a program did, and how it ended."""

    calls: list[Call] = field(default_factory=list)
    code: int = 0


def record(folder: Path, module: str, *arguments: str) -> Recorded:
    """Run `python -m module arguments`, noting what it does in `folder`."""
    ours, theirs = socket.socketpair()
    program = [sys.executable, "-m", "tests.recordings.system_calls", str(theirs.fileno()), module, *arguments]
    process = subprocess.Popen(program, pass_fds=[theirs.fileno()], stdout=subprocess.DEVNULL)
    theirs.close()
    with ours:
        _, descriptors, _, _ = socket.recv_fds(ours, 1, 1)
    assert descriptors, "this kernel has no notifications of seccomp: Linux 5.5 or newer is needed"
    found, [listener] = Recorded(), descriptors
    while process.poll() is None:
        if select.select([listener], [], [], 0.1)[0]:
            _serve(listener, folder.resolve(), found.calls)
    os.close(listener)
    found.code = process.returncode
    return found


def _serve(listener: int, folder: Path, calls: list[Call]) -> None:
    notice = bytearray(NOTICE.size)
    try:
        fcntl.ioctl(listener, RECEIVE, notice)
    except OSError:  # its process was killed meanwhile
        return
    id, thread, _, number, _, _, *arguments = NOTICE.unpack(notice)
    names = {number: name for name, number in NUMBERS[platform.machine()].items()}
    call = None
    try:
        if (call := _Reader(thread, folder).call(names[number], arguments)) is not None:
            calls.append(call)
    except (FileNotFoundError, ProcessLookupError):  # a descriptor that is none
        pass
    try:
        fcntl.ioctl(listener, SEND, ANSWER.pack(id, 0, 0, 0 if call and call.name == "sync" else GO_ON))
    except OSError:
        pass


class _Reader:
    """Understands a call of a thread that stands still."""

    def __init__(self, thread: int, folder: Path) -> None:
        self._thread, self._folder = thread, folder

    def call(self, name: str, a: list[int]) -> Call | None:
        """The call, None where it is none of the folder's."""
        match name:
            case "write" | "pwrite64" | "writev" | "pwritev" | "pwritev2":
                return self._write(name, a)
            case "fsync" | "fdatasync":
                return self._noted("sync", self._of(a[0]))
            case "ftruncate":
                return self._noted("truncate", self._of(a[0]), offset=a[1])
            case "openat" | "creat":
                return self._create(name, a)
            case "rename" | "link":
                return self._noted(name, self._at(AT_FDCWD, a[0]), self._at(AT_FDCWD, a[1]))
            case "renameat" | "renameat2" | "linkat":
                kind = "link" if name == "linkat" else "rename"
                return self._noted(kind, self._at(a[0], a[1]), self._at(a[2], a[3]))
            case "unlink" | "rmdir":
                return self._noted("remove", self._at(AT_FDCWD, a[0]))
            case "unlinkat":
                return self._noted("remove", self._at(a[0], a[1]))
            case "mkdir":
                return self._noted("mkdir", self._at(AT_FDCWD, a[0]))
            case "mkdirat":
                return self._noted("mkdir", self._at(a[0], a[1]))
        touched = {self._of(a[0]), self._of(a[2] if name == "copy_file_range" else a[0])}
        assert touched == {None}, f"{name} on {touched}: this recorder does not know what it does"
        return None

    def _write(self, name: str, a: list[int]) -> Call | None:
        if a[0] == 1 and name == "write":
            return Call(self._thread, time.monotonic(), "said", data=self._memory(a[1], a[2]))
        path = self._of(a[0])
        if path is None:
            return None
        parts = [(a[1], a[2])] if name in ("write", "pwrite64") else self._vectors(a[1], a[2])
        data = b"".join(self._memory(*part) for part in parts)
        info = dict(line.split(":\t") for line in Path(f"/proc/{self._thread}/fdinfo/{a[0]}").read_text().splitlines())
        at = a[3] if name.startswith("p") else int(info["pos"])
        if int(info["flags"], 8) & os.O_APPEND:
            at = os.stat(f"/proc/{self._thread}/fd/{a[0]}").st_size
        return self._noted("write", path, offset=at, data=data)

    def _create(self, name: str, a: list[int]) -> Call | None:
        path, flags = (
            (self._at(a[0], a[1]), a[2]) if name == "openat" else (self._at(AT_FDCWD, a[0]), O_CREAT | O_TRUNC)
        )
        if path is None:
            return None
        there = (self._folder / path).exists()
        if not there:
            return self._noted("create", path) if flags & O_CREAT else None
        return self._noted("truncate", path) if flags & O_TRUNC and not flags & O_EXCL else None

    def _noted(
        self, name: str, path: str | None, to: str | None = "", offset: int = 0, data: bytes = b""
    ) -> Call | None:
        if path is None and to in ("", None):
            return None
        assert path is not None and to is not None, "renamed into the folder or out of it"
        return Call(self._thread, time.monotonic(), name, path, to, offset, data)

    def _vectors(self, address: int, count: int) -> list[tuple[int, int]]:
        return list(struct.iter_unpack("<QQ", self._memory(address, 16 * count)))

    def _memory(self, address: int, size: int) -> bytes:
        with open(f"/proc/{self._thread}/mem", "rb", buffering=0) as memory:
            memory.seek(address)
            return memory.read(size)

    def _of(self, descriptor: int) -> str | None:
        return self._inside(os.readlink(f"/proc/{self._thread}/fd/{descriptor}"))

    def _at(self, folder: int, address: int) -> str | None:
        with open(f"/proc/{self._thread}/mem", "rb", buffering=0) as memory:
            memory.seek(address)
            text = memory.read(4096).split(b"\0", 1)[0].decode()
        folder = folder - (1 << 32) if folder >= 1 << 31 and folder < 1 << 32 else folder
        here = "cwd" if folder in (AT_FDCWD, AT_FDCWD + (1 << 64)) else f"fd/{folder}"
        return self._inside(os.path.normpath(os.path.join(os.readlink(f"/proc/{self._thread}/{here}"), text)))

    def _inside(self, path: str) -> str | None:
        where = Path(path)
        if path.endswith(" (deleted)") or not where.is_relative_to(self._folder):
            return None
        return str(where.relative_to(self._folder))


def _install(to: socket.socket) -> None:
    """From now on every such call of this process and its children waits until it was noted."""
    machine = platform.machine()
    numbers = NUMBERS[machine]
    others = sorted(number for name, number in numbers.items() if name != "openat")
    load, equal, any_bit, back = 0x20, 0x15, 0x45, 0x06
    allow, notify = 0x7FFF0000, 0x7FC00000
    total = len(others)
    code = [
        (load, 0, 0, 4), (equal, 1, 0, ARCHES[machine]), (back, 0, 0, allow),
        (load, 0, 0, 0), (equal, 0, 3, numbers["openat"]), (load, 0, 0, 32), (any_bit, total + 2, 0, O_CREAT | O_TRUNC),
        (back, 0, 0, allow),
        *((equal, total - place, 0, number) for place, number in enumerate(others)),
        (back, 0, 0, allow), (back, 0, 0, notify),
    ]  # fmt: skip
    text = ctypes.create_string_buffer(b"".join(struct.pack("<HBBI", *line) for line in code))
    filter = struct.pack("<HxxxxxxQ", len(code), ctypes.addressof(text))
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(38, 1, 0, 0, 0)
    listener = libc.syscall(SECCOMP[machine], 1, 1 << 3, filter)
    if listener >= 0:
        socket.send_fds(to, [b"x"], [listener])
        os.close(listener)
    to.close()


if __name__ == "__main__":
    _install(socket.socket(fileno=int(sys.argv[1])))
    sys.argv = sys.argv[2:]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
