"""What a recording may keep of every tick, and what that takes."""

from fastapi import APIRouter

from recordings.format.profiles import PROFILES, ProfileInfo

router = APIRouter(tags=["recordings"])


@router.get("/api/recordings/profiles")
async def recording_profiles() -> tuple[ProfileInfo, ...]:
    """The profiles, the default first, with their size per hour."""
    return PROFILES
