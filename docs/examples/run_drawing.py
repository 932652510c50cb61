"""Upload a path, follow it on the rig, and print what came of it.

    python run_drawing.py 'http://127.0.0.1:8321/?token=TOKEN' spiral.csv

The token must be the operator's. While the run is on, this program is the operator: it says so 20 times a second on the
live socket, and the rig holds half a second after it stopped doing that, as it should.
"""

import argparse
import json
import threading
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from client import FRAME, ask, kind_of, live_socket, read_frame, read_text, row_layout, sign_in
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

ENDS = ("done", "stopped", "broken off")
VENTED, HOLD = 0, 1


def main() -> None:
    """Sign in, take the lease, follow, rest. Whatever happens the lease is given back, and a motion is held by that."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("address", help="as `tendril up` prints it, the operator's token included")
    parser.add_argument("path", type=Path, help="CSV file with columns t, x, y")
    given = parser.parse_args()
    client = sign_in(given.address)
    ask(client, "POST", "/api/lease")
    try:
        with live_socket(client) as socket:
            over = threading.Event()
            threading.Thread(target=be_present, args=(socket, over)).start()
            try:
                layout = row_layout(read_text(socket.recv()))
                drawing = upload(client, given.path)
                arm(client)
                wait_for_mode(HOLD, socket, layout)
                follow(client, socket, drawing)
                ask(client, "POST", "/api/command", json={"request": "rest"})
                wait_for_mode(VENTED, socket, layout)
            finally:
                over.set()
    finally:
        client.delete("/api/lease")


def be_present(socket: ClientConnection, over: threading.Event) -> None:
    """Signs of an operator: a number that rises, 20 times a second."""
    n = 0
    while not over.wait(0.05):
        n += 1
        try:
            socket.send(json.dumps({"type": "presence", "n": n}))
        except ConnectionClosed:
            return


def arm(client: httpx.Client) -> None:
    """To HOLD, where the rig is not there already: a refusal says in which mode it is."""
    answer = client.post("/api/command", json={"request": "arm"})
    if answer.is_error and answer.json().get("mode") != HOLD:
        raise SystemExit(f"the rig cannot be armed: {answer.text}")


def wait_for_mode(mode: int, socket: ClientConnection, layout: np.dtype) -> None:
    """Until a frame shows it: to come to rest takes some time."""
    for message in socket:
        if isinstance(message, bytes) and kind_of(message) == FRAME and read_frame(message, layout)["mode"] == mode:
            return


def upload(client: httpx.Client, path: Path) -> dict[str, Any]:
    """The file as a drawing, kept on the server under the file's name."""
    text, csv = path.read_bytes(), {"content-type": "text/csv"}
    read = ask(client, "POST", "/api/drawings/import", content=text, headers=csv)
    for note in read["notes"]:
        print(note)
    drawing = {"name": path.stem, "points": read["points"], "times": read["times"], "timing": {"kind": "given"}}
    plan = ask(client, "POST", "/api/drawings/plan", json=drawing)
    print(f"{path.stem}: {1e3 * plan['length']:.0f} mm in {plan['duration']:.1f} s")
    ask(client, "PUT", f"/api/drawings/{path.stem}", json=drawing)
    return drawing


def follow(client: httpx.Client, socket: ClientConnection, drawing: dict[str, Any]) -> None:
    """Run once, and wait for the end; the run gets a recording of its own."""
    run = ask(client, "POST", "/api/run", json={"drawing": drawing, "laps": 1})
    shown = ""
    for message in socket:
        status = read_text(message) if isinstance(message, str) else {}
        if status.get("type") != "status" or not status["run"] or status["run"]["id"] != run["id"]:
            continue
        run = status["run"]
        if run["state"] != shown:
            shown = run["state"]
            print(f"{shown} {run['reason']}".rstrip())
        if shown in ENDS:
            break
    result = ask(client, "GET", "/api/runs")[0]
    rmse = "none" if result["rmse"] is None else f"{1e3 * result['rmse']:.2f} mm"
    print(f"rmse {rmse}, recording {result['recording']}")


if __name__ == "__main__":
    main()
