"""Sizes of what goes between the tick and the controller in its slot (controller/kernels/slot.py)."""

TUNING = 16
"""Numbers that a controller may be tuned by."""
SIGNALS = 8
"""Numbers that it may show."""
PAPER, PREVIEW = 0, 2
"""Which of a rig's controllers they are; a server begins with `preview`."""
PREVIEW_TUNING = (0.3, 4.0, 0.1)
"""K_P, K_I [1/s] and lag [s] of `preview`, as usual."""
