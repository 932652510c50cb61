"""The process behind `vendor.py`: prints "ready", then a line of JSON for each frame. It imports nothing of ours.

python vendor_process.py SYSTEM '{"hostname": "192.168.1.10"}'
"""

import json
import os
import signal
import sys
import threading
import time

import motioncapture
import numpy  # noqa: F401  positions are arrays: else the first frame would wait for this import

CONNECTING = 10
"""A connection holds up every thread here; the system ends the process when it takes longer [s]."""


def main(system: str, config: str) -> None:
    """Until standard input or output is closed."""
    signal.alarm(CONNECTING)
    source = motioncapture.connect(system, json.loads(config))
    signal.alarm(0)
    threading.Thread(target=_end_with_the_parent, daemon=True).start()
    out = sys.stdout.buffer
    out.write(b"ready\n")
    out.flush()
    while True:
        source.waitForNextFrame()
        arrived = time.monotonic_ns()
        bodies = {name: [float(x) for x in body.position] for name, body in source.rigidBodies.items()}
        out.write(json.dumps({"t": arrived, "bodies": bodies}).encode() + b"\n")
        out.flush()


def _end_with_the_parent() -> None:
    sys.stdin.buffer.read()
    os._exit(0)


if __name__ == "__main__":
    try:
        main(sys.argv[1], sys.argv[2])
    except (BrokenPipeError, KeyboardInterrupt):
        os._exit(0)
    except Exception as error:
        print(json.dumps({"error": str(error)}), flush=True)
        os._exit(1)
