"""The colours of the roles as viser takes them, and those that only the 3D view has."""

from controller.schema import palette

Colour = tuple[int, int, int]

REFERENCE, MEASURED, OBSERVER = (palette.rgb(role) for role in (palette.REFERENCE, palette.MEASURED, palette.OBSERVER))
TWIN, GHOST, DANGER = (palette.rgb(role) for role in (palette.TWIN, palette.GHOST, palette.DANGER))
TARGET: Colour = (255, 255, 255)
BASE: Colour = (110, 110, 110)
