"""A run of the offline observer as a recording: every decay one after the other, measured beside estimated."""

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from controller.errors import RecordingError
from controller.research.identification.observe import Observed
from controller.schema.palette import MEASURED, OBSERVER
from recordings.format.blueprint import APPLICATION
from recordings.format.signals import rgba

PAUSE = 0.5
"""Between two decays on the timeline [s]."""
MILLI = 1e3


def write_observed(observed: Observed, path: Path) -> None:
    """Lateral motion [mm] of every body, measured and estimated; RecordingError when `path` cannot be written."""
    bodies = observed.motions[0].moved.shape[1]
    rr.set_strict_mode(True)
    stream = rr.RecordingStream(APPLICATION)
    try:
        stream.save(path, default_blueprint=_blueprint(observed, bodies))
    except (OSError, RuntimeError) as error:
        raise RecordingError(f"{path} cannot be written: {error}") from error
    for body in range(bodies):
        for name, colour in (("measured", MEASURED), ("estimated", OBSERVER)):
            style = rr.SeriesLines(colors=rgba([colour]), names=name)
            stream.log(_path(body, name), style, static=True)
    begin = 0.0
    for motion, estimate in zip(observed.motions, observed.estimates, strict=True):
        times = [rr.TimeColumn("t", duration=begin + motion.t)]
        for body in range(bodies):
            for name, y in (("measured", motion.lateral[:, body]), ("estimated", estimate[:, body, 1])):
                stream.send_columns(_path(body, name), times, rr.Scalars.columns(scalars=MILLI * y))
        stream.set_time("t", duration=begin)
        stream.log("/log", rr.TextLog(f"ID {motion.id}"))
        begin += float(motion.t[-1]) + PAUSE
    stream.disconnect()


def _path(body: int, name: str) -> str:
    return f"/body_{body + 1}/{name}"


def _blueprint(observed: Observed, bodies: int) -> rrb.Blueprint:
    """One plot a body, the outermost one on top."""
    sensed = observed.scores["sensed"]
    names = [f"Body {i + 1}, {'sensed' if i + 1 in sensed else 'estimated'}: lateral [mm]" for i in range(bodies)]
    plots = [rrb.TimeSeriesView(origin=f"/body_{i + 1}", name=names[i]) for i in reversed(range(bodies))]
    return rrb.Blueprint(
        rrb.Vertical(*plots, rrb.TextLogView(origin="/log", name="Decays"), row_shares=[*np.full(bodies, 3.0), 1.0]),
        auto_layout=False,
        auto_views=False,
    )
