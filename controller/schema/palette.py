"""One colour per role, the same on the page, in the 3D view, in recordings, exports and reports. Colour-blind safe.

The page's own list is frontend/src/ui/colours.ts; tests/test_palette.py compares them.
"""

REFERENCE, MEASURED, OBSERVER, TWIN, GHOST, DANGER = 0xE69F00, 0x009E73, 0x56B4E9, 0x999999, 0xCC79A7, 0xD55E00
"""0xRRGGBB. GHOST is what is predicted."""

LINES = (0xA78BFA, 0xB5A900, 0xB0805A, 0x7C93B2, 0xD884B5, 0x4FB8A8, 0xE07B5A, 0x8FA83C)
"""What has no role, in turn: components, chambers, powers."""


def css(colour: int) -> str:
    """`#RRGGBB`."""
    return f"#{colour:06X}"


def rgb(colour: int) -> tuple[int, int, int]:
    """Red, green and blue, each 0 to 255."""
    return colour >> 16, colour >> 8 & 0xFF, colour & 0xFF


def pale(colour: int, share: float) -> int:
    """The same hue, `share` of the way to white."""
    red, green, blue = (round(part + share * (255 - part)) for part in rgb(colour))
    return red << 16 | green << 8 | blue
