"""Deleting a recording for good."""

from controller.errors import RecordingError
from recordings import sidecar
from recordings.messages import Recording
from recordings.store import Store


def require_removable(store: Store, id: str) -> Recording:
    """The recording `id`; RecordingError when there is none, it has a star, or it is being written."""
    found = store.find(id)
    if found.starred:
        raise RecordingError(f"recording {id!r} has a star: take that away first")
    held = sidecar.lock(store.path(id))
    if held is None:
        raise RecordingError(f"recording {id!r} is still being written")
    held.close()
    return found


def remove(store: Store, id: str) -> None:
    """Delete data and description; RecordingError as `require_removable`."""
    require_removable(store, id)
    path = store.path(id)
    path.unlink()
    path.with_suffix(".json").unlink(missing_ok=True)
