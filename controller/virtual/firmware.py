"""The firmware built for this machine, once for each state of its sources."""

import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from controller.errors import TendrilError

HERE = Path(__file__).resolve().parent
PLACES = (HERE.parents[1] / "firmware", HERE.parent / "firmware")
"""In the repository, and in an installed package."""
COMPILERS = ("g++", "c++", "clang++")
FLAGS = ("-std=c++11", "-O2", "-Wall", "-Wextra", "-fno-exceptions", "-fno-rtti")
KEPT = "tendril-board"
WATCHDOG_MS = 100
"""Without a command for so long a board vents."""


def firmware_folder() -> Path:
    """Where the sources lie; TendrilError where they were left out."""
    for place in PLACES:
        if (place / "host" / "main.cpp").is_file():
            return place
    raise TendrilError(f"the firmware's sources are missing: {PLACES[0]}")


def built_firmware(watchdog_ms: int = WATCHDOG_MS) -> Path:
    """The program of `firmware/host/main.cpp`, built if it has not been; TendrilError where that cannot be done."""
    sources = firmware_folder()
    folder = cache_folder() / source_hash(sources)
    program = folder / f"{KEPT}-{watchdog_ms}"
    if not program.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        build(sources / "host" / "main.cpp", program, (*FLAGS, f"-DTENDRIL_WATCHDOG_MS={watchdog_ms}"))
    return program


def compiler() -> str | None:
    """The C++ compiler of this machine, if it has one."""
    return next((found for name in COMPILERS if (found := shutil.which(name))), None)


def build(source: Path, program: Path, flags: Sequence[str] = FLAGS) -> None:
    """Build `program` of `source`, whole or not at all; TendrilError with what the compiler said."""
    found = compiler()
    if found is None:
        raise TendrilError("a virtual serial board needs a C++ compiler. On Debian: apt-get install g++")
    draft = program.with_name(f"{program.name}.{os.getpid()}")
    try:
        done = subprocess.run([found, *flags, "-o", str(draft), str(source)], capture_output=True, text=True)
        if done.returncode != 0:
            raise TendrilError(f"{found} does not build {source}: {done.stderr.strip()[:400]}")
        os.replace(draft, program)
    finally:
        draft.unlink(missing_ok=True)


def source_hash(sources: Path) -> str:
    """Sixteen hex digits of everything that the program is built of."""
    found = hashlib.sha256(" ".join(FLAGS).encode())
    for file in sorted([*sources.glob("host/*"), *sources.glob("src/core/*")]):
        found.update(file.read_bytes())
    return found.hexdigest()[:16]


def cache_folder() -> Path:
    """Of this user alone: what lies there is run."""
    place = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tendril" / "firmware"
    try:
        place.mkdir(parents=True, exist_ok=True)
        writable = os.access(place, os.W_OK)
    except OSError:
        writable = False
    return place if writable else Path(tempfile.mkdtemp(prefix="tendril-firmware-"))
