"""The rig's modes and causes as people read them."""

from controller.schema.modes import Cause, Mode


def words(member: Mode | Cause) -> str:
    """A mode or a cause as people read it."""
    return member.name.replace("_", " ").lower() if isinstance(member, Cause) else member.name.replace("_", " ")
