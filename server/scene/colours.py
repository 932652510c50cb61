"""One colour per role, the same as on the page and in recordings (colour-blind safe), as viser takes them."""

Colour = tuple[int, int, int]

REFERENCE = (230, 159, 0)
MEASURED = (0, 158, 115)
OBSERVER = (86, 180, 233)
TWIN = (153, 153, 153)
GHOST = (204, 121, 167)
DANGER = (213, 94, 0)
TARGET = (255, 255, 255)
BASE = (110, 110, 110)
