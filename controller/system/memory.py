"""What a process keeps in memory though it needs it no more: free pages of glibc's arenas, and what ran once.

Each thread allocates from an arena, and what an arena has had it keeps. rerun writes every recording by threads of its
own, which come upon one arena after the other: a server that records all day would grow for hours without one byte
lost. And a start runs through 80 MB of compilers and readers that are not called again. Other C libraries and systems
have nothing of this, and nothing is done there.
"""

import ctypes
import gc
import re
from collections.abc import Iterator
from pathlib import Path

M_ARENA_MAX = -8
ARENAS = 2
"""glibc's own choice is eight for every core."""
MADV_DONTNEED = 4
SELDOM = 200
"""Collections of the middle generation for each one of the oldest, which stops all threads: for 50 ms where a thousand
connections are open. Python's own choice is 10, which under a flood of connections is every third second.
"""
LARGE = 1 << 22
"""Parts of libraries that are smaller than this stay as they are [bytes]."""
MAPS = Path("/proc/self/smaps")
MAPPING = re.compile(r"(?P<begin>[0-9a-f]+)-(?P<end>[0-9a-f]+) (?P<access>\S+) \S+ \S+ \d+ *(?P<name>.*)")
"""First line of what is said of one mapping; proc(5)."""

_libc = ctypes.CDLL(None)


def few_arenas() -> None:
    """All threads of this process share `ARENAS`, and those that there are already."""
    if hasattr(_libc, "mallopt"):
        _libc.mallopt(M_ARENA_MAX, ARENAS)


def give_back() -> None:
    """Hand free pages back to the system."""
    if hasattr(_libc, "malloc_trim"):
        _libc.malloc_trim(0)


def collect_seldom() -> None:
    """What became old is looked through for garbage but seldom; what is young as often as ever."""
    young, middle, _ = gc.get_threshold()
    gc.set_threshold(young, middle, SELDOM)


def forget_start() -> None:
    """Give back what only the start needed, and take what is left of it from the garbage collector.

    What lies in a file is read again from there where it is used once more.
    """
    gc.collect()
    gc.freeze()
    give_back()
    for begin, size in _large_parts():
        _libc.madvise(ctypes.c_void_p(begin), ctypes.c_size_t(size), MADV_DONTNEED)


def _large_parts() -> Iterator[tuple[int, int]]:
    """Address and size of code and constants of large libraries: mapped read-only, and no page differs from the file.

    Those that do, where the linker has put addresses in, could not be read again.
    """
    begin = size = 0
    for line in MAPS.read_text().splitlines() if MAPS.exists() else ():
        if mapping := MAPPING.match(line):
            begin, end = int(mapping["begin"], 16), int(mapping["end"], 16)
            is_library = mapping["access"] in ("r-xp", "r--p") and ".so" in mapping["name"]
            size = end - begin if is_library else 0
        elif size > LARGE and line.split() == ["Anonymous:", "0", "kB"]:
            yield begin, size
