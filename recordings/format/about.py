"""What an .rrd says about itself beside its rows: the words of its "About" tab."""

import json
from dataclasses import dataclass
from typing import Any

from controller.schema.messages import RigInfo, Telemetry
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import Settings
from recordings.format.messages import Profile
from recordings.format.profiles import meaning


@dataclass(frozen=True)
class About:
    """What a recording says about itself beside its rows."""

    id: str
    name: str
    info: RigInfo
    settings: Settings
    profile: Profile = "full"


def word(value: Mode | Cause) -> str:
    """A mode or a cause as people read it."""
    return "E-STOP" if value == Mode.E_STOP and isinstance(value, Mode) else value.name.replace("_", " ")


def description(about: About) -> str:
    """The "About" tab: who, what, and every parameter."""
    info = about.info
    simulated = "Cosserat rod" if info.parameters.twin.plant == "cosserat" else "chain of rods"
    source = f"twin (actuator simulated as a {simulated})" if info.twin else "hardware"
    lines = [
        f"# {about.name}",
        f"{info.parameters.actuator.name}, {source}, rig `{info.rig}`, {info.program}, loop {info.policy}.",
        f"Profile {about.profile}: {meaning(about.profile)}. SI units.",
        "Plan view: grid 50 mm; rerun's y points down, so y is negated there. Observer blue, measured green, reference "
        "amber with a trail of 2 s, target pale amber, twin grey.",
        *(_table(title, part) for title, part in (("Settings at the start", about.settings), *info.parameters) if part),
        f"Record layout `{info.layout}` ({len(Telemetry.model_fields)} fields), boot `{info.boot}`.",
    ]
    return "\n\n".join(lines)


def _table(title: str, part: Any) -> str:
    rows = "\n".join(f"| {name} | `{json.dumps(value)}` |" for name, value in part.model_dump(mode="json").items())
    return f"## {title.capitalize()}\n\n| parameter | value |\n|---|---|\n{rows}"
