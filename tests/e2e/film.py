"""`python -m tests.e2e.film FILE.webp`: the README's moving picture, taken of the real page during a drag."""

import math
import sys
import tempfile
from pathlib import Path

from PIL import Image

from controller.schema.modes import Mode
from server.app.browser import launch_chromium
from tests.e2e.hand import Hand, arm
from tests.e2e.product import Product, open_page
from tests.e2e.screencast import Shown, screencast

VIEWPORT = {"width": 1280, "height": 720}
WIDTH = 880
"""Of the picture [pixels]."""
FRAMES = 48
TURNS = 1
RADIUS = 36.0
"""Of the drag [pixels]."""
QUALITY = 50


def film() -> list[Shown]:
    """Frames of a turn of the target, with the tip behind it."""
    with Product(Path(tempfile.mkdtemp(prefix="tendril-film-"))) as product, launch_chromium() as browser:
        page = open_page(browser.new_context(viewport=VIEWPORT), product)
        arm(page)
        hand = Hand(page, product)
        hand.press()
        hand.wait(Mode.FOLLOW)
        found, frames = list[Shown](), screencast(page)
        for k in range(FRAMES):
            angle, step = 2 * math.pi * TURNS * k / FRAMES, 2 * math.pi * TURNS * RADIUS / FRAMES
            hand.move(-step * math.sin(angle), step * math.cos(angle))
            found.append(next(frames))
        frames.close()
        hand.up()
        return found


def write(frames: list[Shown], path: Path) -> None:
    """As an animation without end, at the pace at which it was shown."""
    pictures = [Image.fromarray(frame.pixels) for frame in frames]
    small = [one.resize((WIDTH, round(WIDTH * one.height / one.width)), Image.Resampling.LANCZOS) for one in pictures]
    each = round(1e3 * (frames[-1].at - frames[0].at) / (len(frames) - 1))
    small[0].save(path, save_all=True, append_images=small[1:], duration=each, loop=0, quality=QUALITY, method=6)


if __name__ == "__main__":
    write(film(), Path(sys.argv[1]))
