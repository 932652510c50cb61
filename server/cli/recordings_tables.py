"""What `tendril recordings` prints."""

from collections.abc import Sequence

from rich.markup import escape
from rich.table import Table
from rich.text import Text

from recordings.format.messages import Recording
from recordings.store.comparing import Compared
from server.cli.tables import empty, number

MILLI = 1e3
ROWS: dict[str, tuple[str, float]] = {
    "approach": ("approach, left out [s]", 1.0),
    "rmse": ("RMSE [mm]", MILLI),
    "max_error": ("largest error [mm]", MILLI),
    "sse": ("SSE [mm]", MILLI),
    "ise": ("ISE [mm^2 s]", MILLI**2),
    "lag_deg_x": ("lag in x [deg]", 1.0),
    "lag_deg_y": ("lag in y [deg]", 1.0),
    "saturated_share": ("saturated [%]", 100.0),
    "residual_rms": ("observer residual [mm]", MILLI),
    "unsensed_rms": ("unsensed rods [mm]", MILLI),
    "feedback_share": ("feedback share [%]", 100.0),
    "lost": ("lost ticks", 1.0),
    "on_time_share": ("on time [%]", 100.0),
    "apart_rms": ("tip from that of 1, RMS [mm]", MILLI),
    "apart_max": ("tip from that of 1, largest [mm]", MILLI),
}
"""Name and factor of every figure."""
NUMBERS = ("length", "size", "RMSE", "gaps")
NAME_WIDTH = 12
"""Characters of a name that are shown however narrow the terminal is."""


def listing(recordings: Sequence[Recording]) -> Table:
    """One row a recording; where the terminal is narrow, names are cut and marks take more lines."""
    table = empty(f"{len(recordings)} recordings", ("id", "name", *NUMBERS, ""), NUMBERS)
    name, state = table.columns[1], table.columns[-1]
    name.min_width, name.no_wrap, state.no_wrap = NAME_WIDTH, False, False
    for one in recordings:
        rmse = one.metrics.rmse if one.metrics else None
        error = "-" if rmse is None else f"{number(MILLI * rmse)} mm"
        numbers = (f"{one.seconds:.1f} s", f"{one.bytes / 1e6:.1f} MB", error, str(one.gaps))
        table.add_row(one.id, Text(one.name, no_wrap=True, overflow="ellipsis"), *numbers, marks(one))
    return table


def details(one: Recording) -> Table:
    """Facts, one a line, and figures where there are some."""
    source = "elsewhere" if one.imported else "twin" if one.twin else "hardware"
    facts = {
        "name": one.name,
        "started": one.started.isoformat(sep=" ", timespec="seconds"),
        "length": f"{one.seconds:.3f} s, {one.rows} rows, {one.gaps} missing ticks",
        "rig restarted": ", ".join(f"{at.seconds:.1f} s after tick {at.after}" for at in one.restarts) or "-",
        "size": f"{one.bytes / 1e6:.1f} MB, {one.profile}",
        "source": f"{one.actuator or '-'}, {source}, rig {one.rig or '-'}",
        "operator": one.operator or "-",
        "reference": one.reference or "-",
        "tags": ", ".join(one.tags) or "-",
        "notes": one.notes or "-",
        "state": marks(one) or "whole",
    }
    table = empty(one.id, ("", " "), ())
    table.columns[1].no_wrap = False
    for name, text in facts.items():
        table.add_row(name, escape(text))
    for name, value in (one.metrics.model_dump() if one.metrics else {}).items():
        if value is not None:
            table.add_row(escape(ROWS[name][0]), number(ROWS[name][1] * value))
    return table


def comparison_table(found: Sequence[Compared]) -> Table:
    """One column a recording, by its place; one row a figure that at least one of them has."""
    heads = [str(place) for place in range(1, len(found) + 1)]
    table = empty("Side by side", ("", *heads), heads)
    table.add_row(escape("length [s]"), *(f"{one.recording.seconds:.3f}" for one in found))
    for key, (title, factor) in ROWS.items():
        values = [one.figures.get(key) for one in found]
        if any(value is not None for value in values):
            table.add_row(escape(title), *(number(None if value is None else factor * value) for value in values))
    return table


def marks(one: Recording) -> str:
    """What is particular about it, in words."""
    said = {
        "starred": one.starred,
        "imported": one.imported,
        "recovered": one.recovered,
        "cut short": not one.complete and not one.recovered,
    }
    return ", ".join(word for word, holds in said.items() if holds)
