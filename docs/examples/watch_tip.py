"""Watch the tip: sign in, follow the live socket for some seconds, print where the measured tip is.

python watch_tip.py 'http://127.0.0.1:8321/?token=TOKEN' --seconds 10
"""

import argparse
import json
import time

import numpy as np
from client import FRAME, kind_of, live_socket, read_frame, read_plot, read_text, row_layout, sign_in
from websockets.sync.client import ClientConnection

EVERY = 0.5
"""Between two lines [s]; the server sends up to 60 frames a second."""


def main() -> None:
    """Print a line each half second, and at the end the largest error of all samples, those between frames included."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("address", help="as `tendril up` prints it, the token included")
    parser.add_argument("--seconds", type=float, default=10.0)
    given = parser.parse_args()
    with live_socket(sign_in(given.address)) as socket:
        watch(socket, given.seconds)


def watch(socket: ClientConnection, seconds: float) -> None:
    """Frames hold the newest row; PLOT messages the extremes of every sample of the channels that were asked for."""
    hello = read_text(socket.recv())
    layout = row_layout(hello)
    print(f"rig {hello['rig']['rig'] if hello['rig'] else 'not heard yet'}, {len(hello['channels'])} channels")
    socket.send(json.dumps({"type": "plots", "channels": ["error.norm"], "since": None}))
    frames, largest, next_line, end = 0, 0.0, 0.0, time.monotonic() + seconds
    while time.monotonic() < end:
        message = socket.recv(timeout=10.0)
        if isinstance(message, str):
            continue
        if kind_of(message) != FRAME:
            largest = np.fmax(largest, np.nanmax(read_plot(message).high, initial=0.0))
            continue
        frames += 1
        if time.monotonic() >= next_line:
            next_line = time.monotonic() + EVERY
            row = read_frame(message, layout)
            x, y = 1e3 * row["p_meas"]
            print(f"t = {1e-9 * row['t_ns']:.3f} s  tip = ({x:.2f}, {y:.2f}) mm  mode {row['mode']}")
    print(f"{frames} frames; the largest error was {1e3 * largest:.2f} mm")


if __name__ == "__main__":
    main()
