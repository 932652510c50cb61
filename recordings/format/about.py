"""What an .rrd says about itself beside its rows: the words of its "About" tab, and how its plots look."""

import json
from dataclasses import dataclass
from typing import Any

import rerun as rr

from controller.schema.messages import RigInfo, Telemetry
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import Settings
from recordings.format.messages import Profile
from recordings.format.profiles import meaning
from recordings.format.signals import MODE_COLORS, Group, rgba


@dataclass(frozen=True)
class About:
    """What a recording says about itself beside its rows."""

    id: str
    name: str
    info: RigInfo
    settings: Settings
    profile: Profile = "full"


def series_style(group: Group) -> rr.SeriesLines:
    """Names, colours and widths of the group's lines."""
    return rr.SeriesLines(
        names=[series.name for series in group.series],
        colors=rgba(series.color for series in group.series),
        widths=[series.width for series in group.series],
    )


def mode_style() -> rr.StateConfiguration:
    """The band of modes: a word and a colour each."""
    words = [word(mode) for mode in Mode]
    return rr.StateConfiguration(values=words, labels=words, colors=rgba(MODE_COLORS[mode] for mode in Mode))


def word(value: Mode | Cause) -> str:
    """A mode or a cause as people read it."""
    return "E-STOP" if value == Mode.E_STOP and isinstance(value, Mode) else value.name.replace("_", " ")


def description(about: About) -> str:
    """The "About" tab: who, what, and every parameter."""
    info = about.info
    source = "twin (simulated actuator)" if info.twin else "hardware"
    lines = [
        f"# {about.name}",
        f"{info.parameters.actuator.name}, {source}, rig `{info.rig}`, {info.program}, loop {info.policy}.",
        f"Profile {about.profile}: {meaning(about.profile)}. SI units.",
        "Plan view: grid 50 mm; rerun's y points down, so y is negated there. Observer blue, measured green, reference "
        "amber with a trail of 2 s, target pale amber, twin grey.",
        *(_table(title, part) for title, part in (("Settings at the start", about.settings), *info.parameters)),
        f"Record layout `{info.layout}` ({len(Telemetry.model_fields)} fields), boot `{info.boot}`.",
    ]
    return "\n\n".join(lines)


def _table(title: str, part: Any) -> str:
    rows = "\n".join(f"| {name} | `{json.dumps(value)}` |" for name, value in part.model_dump(mode="json").items())
    return f"## {title.capitalize()}\n\n| parameter | value |\n|---|---|\n{rows}"
