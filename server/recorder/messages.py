"""What a page asks of the recorder, on the wire."""

from typing import Annotated

from pydantic import Field as Bounds

from controller.schema.layout import Model
from recordings.format.messages import Profile


class RecordingBody(Model):
    """Body of POST /api/recordings."""

    name: Annotated[str, Bounds(max_length=80)] = ""
    profile: Profile = "standard"
