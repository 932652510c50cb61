"""`python -m tests.server.measure_ready [--times N]`: how long `tendril up` takes until its page can be opened [s]."""

import argparse
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from controller.realtime.ring import remove_rings
from tests.server.live_server import free_environment

TENDRIL = "from server.cli.main import main; main()"


def main(times: int) -> None:
    free_environment()
    found = []
    for number in range(times):
        with tempfile.TemporaryDirectory(prefix="tendril-ready-") as folder:
            found.append(once(Path(folder), f"ready-{os.getpid()}-{number}"))
        print(f"{found[-1]:.2f} s", flush=True)
    print(f"median {statistics.median(found):.2f} s, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


def once(folder: Path, rig: str) -> float:
    """Seconds from the command to the file that says where the page is."""
    ready = folder / "ready.json"
    command = [sys.executable, "-c", TENDRIL, "up", "--rig", rig, "--port", "0", "--no-browser"]
    command += ["--ready", str(ready), "--recordings", str(folder / "recordings")]
    start = time.monotonic()
    process = subprocess.Popen(
        command,
        env=os.environ | {"XDG_STATE_HOME": str(folder)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while not ready.exists() and process.poll() is None:
        time.sleep(0.01)
    seconds = time.monotonic() - start
    process.send_signal(signal.SIGINT)
    assert process.wait() == 0
    remove_rings(rig)
    return seconds


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=5)
    main(parser.parse_args().times)
