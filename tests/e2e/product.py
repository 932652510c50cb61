"""The whole product as a user starts it: `tendril up` in its own folders, and real chromium on its page."""

import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

import numpy as np
import psutil
from PIL import Image
from playwright.sync_api import BrowserContext, Page

from controller.realtime.ring import find_ring, remove_rings
from controller.schema.modes import Mode
from controller.schema.rig_file import read_rig_file
from server.app.ready import UpReady

SCREENSHOTS = os.environ.get("TENDRIL_SCREENSHOTS", "")
"""Folder for screenshots to look at, "" for none: to draw one in software takes a third of a second of a core."""
OPERATOR_TIMEOUT_S = 3.0
PATIENT = ("--loop-gap", "1.0", "--operator-timeout", str(OPERATOR_TIMEOUT_S))
"""Machines under test pause, loop and page alike; that the rig holds by its own limits is tested without a page."""


class Product:
    """A running `tendril up`, with more options of its own where a test needs them.

    With a rig file it drives the devices of that rather than a twin.
    """

    def __init__(self, folder: Path, *options: str, rig_file: Path | None = None) -> None:
        self.folder = folder
        self.recordings = folder / "recordings"
        ready = folder / "up.json"
        environment = os.environ | {"XDG_STATE_HOME": str(folder / "state"), "TENDRIL_LIGHT_SCENE": "1"}
        self.state = folder / "state" / "tendril"
        environment["TENDRIL_CONTROL_LAPSE"] = "15"  # machines under test pause; that the rig holds then is tested
        environment["TENDRIL_RECORD_FAULTS"] = "0"  # tests stop the rig often, and press the record button themselves
        self.rig = read_rig_file(rig_file).name if rig_file else f"e2e-{os.getpid()}-{folder.name}"
        command = [
            str(Path(sys.executable).parent / "tendril"),
            "up",
            "--no-browser",
            *(() if rig_file else PATIENT),
            "--port",
            "0",
            "--ready",
            str(ready),
        ]
        command += ["--recordings", str(self.recordings), "--rig", str(rig_file or self.rig), *options]
        self.log = (folder / "up.log").open("w")
        self.process = subprocess.Popen(command, env=environment, stdout=self.log, stderr=self.log)
        wait_until(ready.exists, 240.0, self.alive)
        self.ready = UpReady.model_validate_json(ready.read_bytes())

    @property
    def url(self) -> str:
        """Address with the access token."""
        return self.ready.url

    @property
    def origin(self) -> str:
        """Address without it."""
        return self.url.split("/?")[0]

    def child(self, module: str) -> psutil.Process:
        """The process that runs `python -m MODULE` now; waits for it while it is being restarted."""
        found: list[psutil.Process] = []

        def look() -> bool:
            found[:] = [child for child in psutil.Process(self.process.pid).children() if module in child.cmdline()]
            return len(found) == 1

        wait_until(look)
        return found[0]

    def mode(self) -> Mode:
        """The rig's mode as its own ring has it."""
        row = find_ring(self.rig).newest()
        assert row is not None
        return Mode(row["mode"])

    def alive(self) -> None:
        """Fail with the product's own output once it is dead."""
        assert self.process.poll() is None, (self.folder / "up.log").read_text()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Ctrl-C, and a clean end."""
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(30.0)
        self.log.close()
        remove_rings(self.rig)
        assert code == 0, (self.folder / "up.log").read_text()


PATIENCE_S = 90.0
"""Seconds for which a test of the page waits: machines under test pause for half a minute, and none asserts a time."""


def wait_until(
    condition: Callable[[], Any], seconds: float = PATIENCE_S, each: Callable[[], Any] = lambda: None
) -> float:
    """Poll `condition` until it is true; returns the seconds it took, fails after `seconds`."""
    start = time.monotonic()
    while not condition():
        each()
        assert time.monotonic() - start < seconds, f"not within {seconds} s: {condition}"
        time.sleep(0.05)
    return time.monotonic() - start


PAINT_MS = 100
"""Between two paintings of a page under test: to draw all that moves 60 times a second, in software, costs a core."""
PAINT_SELDOM = f"""if (window === window.top) {{
  window.requestAnimationFrame = (paint) => setTimeout(() => paint(performance.now()), {PAINT_MS});
  window.cancelAnimationFrame = clearTimeout;
}}"""


def remember(context: BrowserContext, key: str, value: str) -> None:
    """Put a value into the page's own storage before it is opened; frames with another viewer may have none."""
    context.add_init_script(f"if (window === window.top) localStorage.setItem('{key}', '{value}')")


def open_page(
    context: BrowserContext, product: Product, *, guide: bool = False, with_3d: bool = False, smooth: bool = False
) -> Page:
    """Open the page in a new tab.

    The guide of the first visit and the 3D view only when asked for, and every frame only where it is `smooth`: drawn
    in software they make everything else slow.
    """
    if not smooth:
        context.add_init_script(PAINT_SELDOM)
    if not guide:
        remember(context, "tendril-guide", "seen")
    if not with_3d:
        remember(context, "tendril-3d", "closed")
    page = context.new_page()
    page.set_default_timeout(1e3 * PATIENCE_S)
    return go_to(page, product)


def go_to(page: Page, product: Product) -> Page:
    """Go there by the address with the token, and wait for live telemetry."""
    page.goto(product.url)
    wait_until(lambda: page.evaluate("!!window.__tendril?.frame"))  # by evaluate: the page forbids eval
    return page


def frame(page: Page) -> dict[str, Any]:
    """The newest telemetry record that the page holds, fields by name; metres and radians."""
    return page.evaluate("window.__tendril.frame")  # type: ignore[no-any-return]


def shot(page: Page, name: str) -> None:
    """Keep a screenshot where people asked for them."""
    if SCREENSHOTS:
        page.screenshot(path=Path(SCREENSHOTS, f"{name}.png"), timeout=60_000)


def pixels_of(page: Page, colour: tuple[int, int, int], region: dict[str, float]) -> np.ndarray:
    """Window pixels (n, 2) of `region` that have about this colour: what is drawn in a foreign frame."""
    picture = page.screenshot(clip=region, timeout=1e3 * PATIENCE_S)  # type: ignore[arg-type]
    values = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), float)
    rows, columns = np.nonzero(np.abs(values - colour).max(axis=-1) < 25)
    return np.column_stack([columns + region["x"], rows + region["y"]])
