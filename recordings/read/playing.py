"""rerun's own viewer in a window of its own."""

import os
import subprocess
import sys
from pathlib import Path

from controller.errors import RecordingError
from recordings.format import tool

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


def play(path: Path) -> None:
    """Show the file until the window is closed; RecordingError without a display or when the viewer fails."""
    if sys.platform == "linux" and not any(os.environ.get(name) for name in DISPLAYS):
        raise RecordingError("there is no display for rerun's viewer here: open the recording in the page's Review tab")
    with tool.quiet_home() as environment:
        code = subprocess.run(tool.command(str(path)), env=environment, check=False).returncode
    if code:
        raise RecordingError(f"rerun's viewer ended with code {code}")
