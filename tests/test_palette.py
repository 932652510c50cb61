"""The page and the server draw the same thing in the same colour."""

import re
from pathlib import Path

from controller.schema import palette

PAGE = (Path(__file__).parents[1] / "frontend/src/ui/colours.ts").read_text()


def test_the_page_has_the_roles_and_lines_of_recordings_and_reports() -> None:
    roles = dict(re.findall(r"^  (\w+): \"(#\w{6})\",$", PAGE[: PAGE.index("as const")], re.M))
    assert roles == {name: palette.css(getattr(palette, name.upper())) for name in roles}
    assert set(roles) == {"reference", "measured", "observer", "twin", "ghost", "danger"}
    lines = PAGE[PAGE.index("LINES = [") : PAGE.index("] as const")]
    assert re.findall(r"#\w{6}", lines) == [palette.css(colour) for colour in palette.LINES]


def test_no_colour_means_two_things() -> None:
    roles = [palette.REFERENCE, palette.MEASURED, palette.OBSERVER, palette.TWIN, palette.GHOST, palette.DANGER]
    assert len({*roles, *palette.LINES}) == len(roles) + len(palette.LINES)
