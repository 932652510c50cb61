"""How a recording's data are mended, compacted and counted, with rerun's own tools."""

from pathlib import Path

from recordings.format import frames, sidecar, tool
from recordings.format.messages import Recording
from recordings.read.reader import read_about, read_bookmarks, read_times

MEND_MAX_S = 1800.0
"""For one run of a tool [s]."""


def mend(path: Path, draft: Path) -> None:
    """A copy of the whole frames with a footer: rerun's migration streams, so it needs little memory for any size."""
    frames.copy_whole(path, draft, frames.intact_length(path))
    tool.run("rrd", "migrate", str(draft), timeout=MEND_MAX_S)


def compact(path: Path, draft: Path) -> None:
    """A copy in few large chunks."""
    tool.run("rrd", "optimize", str(path), "-o", str(draft), timeout=MEND_MAX_S)


def count(path: Path) -> dict[str, float]:
    """Rows, missing ticks and seconds that the data come to."""
    tick, t_ns = read_times(path)
    steps = tick[1:] - tick[:-1]
    seconds = float(t_ns[-1] - t_ns[0]) * 1e-9 if len(t_ns) else 0.0
    return {"rows": len(tick), "gaps": int((steps[steps > 1] - 1).sum()), "seconds": seconds}


def from_data(id: str, path: Path) -> Recording:
    """What the data say of themselves; they still have to be counted."""
    info, settings = read_about(path)
    known = {"bytes": path.stat().st_size, "twin": info.twin, "rig": info.rig, "settings": settings}
    known["bookmarks"] = read_bookmarks(path)
    return sidecar.blank(id, actuator=info.parameters.actuator.name).model_copy(update=known)
