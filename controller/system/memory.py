"""What a process keeps in memory though it needs it no more: free pages of glibc's arenas, and code that only ran once.

Each thread allocates from an arena, and what an arena has had it keeps. rerun writes every recording by threads of its
own, which come upon one arena after the other: a server that records all day would grow for hours without one byte
lost. And a start runs through 60 MB of compilers and readers that are not called again. Other C libraries and systems
have nothing of this, and nothing is done there.
"""

import ctypes
from collections.abc import Iterator
from pathlib import Path

M_ARENA_MAX = -8
ARENAS = 2
"""glibc's own choice is eight for every core."""
MADV_DONTNEED = 4
LARGE = 1 << 22
"""Libraries with less code than this stay as they are [bytes]."""
MAPS = Path("/proc/self/maps")

_libc = ctypes.CDLL(None)


def few_arenas() -> None:
    """All threads of this process share `ARENAS`, and those that there are already."""
    if hasattr(_libc, "mallopt"):
        _libc.mallopt(M_ARENA_MAX, ARENAS)


def give_back() -> None:
    """Hand free pages back to the system."""
    if hasattr(_libc, "malloc_trim"):
        _libc.malloc_trim(0)


def forget_start() -> None:
    """Give back what only the start needed. Code is read again from its file where it is called once more."""
    give_back()
    for begin, size in _large_code():
        _libc.madvise(ctypes.c_void_p(begin), ctypes.c_size_t(size), MADV_DONTNEED)


def _large_code() -> Iterator[tuple[int, int]]:
    """Address and size of the code of large libraries: mapped read-only from its file, so nothing in it can be lost."""
    if not MAPS.exists():
        return
    for line in MAPS.read_text().splitlines():
        span, access, *_, name = line.split(maxsplit=5)
        begin, end = (int(address, 16) for address in span.split("-"))
        if access == "r-xp" and ".so" in name and end - begin > LARGE:
            yield begin, end - begin
