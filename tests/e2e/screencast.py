"""When something was on the screen: frames that chromium showed, each with its time."""

import base64
import io
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from playwright.sync_api import Page

PERIOD_MS = 100.0
"""Between two looks: more of them take processor time from what is watched."""


class Shown(NamedTuple):
    """A frame: when it was shown (seconds since 1970), and its pixels (height, width, 3)."""

    at: float
    pixels: np.ndarray

    def count(self, colour: tuple[int, int, int], region: dict[str, float]) -> int:
        """Pixels of `region` that have about this colour."""
        x, y, width, height = (round(region[name]) for name in ("x", "y", "width", "height"))
        part = self.pixels[y : y + height, x : x + width].astype(float)
        return int((np.abs(part - colour).max(axis=-1) < 25).sum())


def screencast(page: Page) -> Iterator[Shown]:
    """Frames of `page`, about ten a second, without end. To ask for pictures instead would make it draw more.

    The generator may be closed at any time.
    """
    session, came = page.context.new_cdp_session(page), list[dict[str, Any]]()
    session.on("Page.screencastFrame", lambda event: came.append(event))
    session.send("Page.startScreencast", {"format": "jpeg", "quality": 90})
    try:
        while True:
            page.wait_for_timeout(PERIOD_MS)
            while came:
                event = came.pop(0)
                picture = Image.open(io.BytesIO(base64.b64decode(event["data"])))
                yield Shown(event["metadata"]["timestamp"], np.asarray(picture.convert("RGB")))
                session.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})
    finally:
        session.detach()
