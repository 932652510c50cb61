"""Both ends of the link must be built from the same definitions of its records; what is said where they are not."""

from controller.errors import LayoutMismatch
from controller.schema.layout import layout_hash
from controller.schema.messages import Command, Telemetry
from controller.system.origin import our_version

OURS = our_version()
LAYOUT = layout_hash(Command, Telemetry)


def require_same(who: str, theirs: str, layout: str, here: str) -> None:
    """Raise LayoutMismatch unless `who`, of version `theirs`, has the records of this end, which is `here`."""
    if layout != LAYOUT:
        raise mismatch(who, theirs, layout, here)


def mismatch(who: str, theirs: str, layout: str, here: str) -> LayoutMismatch:
    """Names both versions and the way out."""
    return LayoutMismatch(
        f"{who} is Tendril {theirs[:40]} with record layout {layout[:40]}, {here} is Tendril {OURS} with {LAYOUT}: "
        "run the same version of Tendril on both machines"
    )
