"""How rerun draws the series of a group."""

import rerun as rr

from recordings.format.signals import Group, rgba


def style(group: Group, units_shown: bool = False) -> rr.SeriesLines:
    """Names, colours and widths of the group's lines; the names with units that people read, or with SI ones."""
    return rr.SeriesLines(
        names=[series.shown[0] if units_shown else series.name for series in group.series],
        colors=rgba(series.color for series in group.series),
        widths=[series.width for series in group.series],
    )
