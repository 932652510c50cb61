"""What glibc keeps of memory that is free. Each thread allocates from an arena, and what an arena has had it keeps.

rerun writes every recording by threads of its own, which come upon one arena after the other: a server that records
all day would grow for hours without one byte lost. Other C libraries have nothing of this, and nothing is done there.
"""

import ctypes

M_ARENA_MAX = -8
ARENAS = 2
"""glibc's own choice is eight for every core."""

_libc = ctypes.CDLL(None)


def few_arenas() -> None:
    """All threads of this process share `ARENAS`, and those that there are already."""
    if hasattr(_libc, "mallopt"):
        _libc.mallopt(M_ARENA_MAX, ARENAS)


def give_back() -> None:
    """Hand free pages back to the system."""
    if hasattr(_libc, "malloc_trim"):
        _libc.malloc_trim(0)
