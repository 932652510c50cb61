"""What every program needs that talks to a Tendril server: a session, the live socket, and what its frames hold.

Needs httpx, websockets and numpy, and nothing of Tendril itself. The formats are described in docs/live.md.
"""

import json
from typing import Any, NamedTuple
from urllib.parse import unquote

import httpx
import numpy as np
from websockets.sync.client import ClientConnection, connect

FRAME, PLOT = 1, 2


class Plot(NamedTuple):
    """Extremes of every 1 kHz sample in successive bins: `t` (n,) [s], `low` and `high` (n, channels), SI units."""

    first: int
    t: np.ndarray
    channels: np.ndarray
    low: np.ndarray
    high: np.ndarray


def sign_in(address: str) -> httpx.Client:
    """A session, from the address that `tendril up` prints: http://HOST:PORT/?token=TOKEN."""
    url, _, token = address.partition("/?token=")
    client = httpx.Client(base_url=url, timeout=60.0)
    ask(client, "POST", "/api/session", json={"token": unquote(token)})
    return client


def ask(client: httpx.Client, method: str, path: str, **more: Any) -> Any:
    """The JSON that answers a request; ends the program with the server's own words where it refuses."""
    answer = client.request(method, path, **more)
    if answer.is_error:
        raise SystemExit(f"{method} {path}: {answer.status_code} {answer.text}")
    return answer.json() if answer.content else None


def live_socket(client: httpx.Client) -> ClientConnection:
    """The live socket of this session. A program sends no Origin; a browser's page must be the server's own."""
    cookies = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    url = str(client.base_url).replace("http", "ws", 1).rstrip("/") + "/ws/live"
    return connect(url, additional_headers={"Cookie": cookies}, max_size=None)


def row_layout(hello: dict[str, Any]) -> np.dtype:
    """How a telemetry row lies in memory, from the first message on the socket; little endian."""
    fields = hello["layout"]
    formats = [(np.dtype(one["type"]).newbyteorder("<"), tuple(one["shape"])) for one in fields]
    return np.dtype(
        {"names": [one["name"] for one in fields], "formats": formats, "offsets": [one["offset"] for one in fields]}
    )


def kind_of(message: bytes) -> int:
    """FRAME or PLOT."""
    return int(np.frombuffer(message, "<u4", 1)[0])


def read_frame(message: bytes, layout: np.dtype) -> np.void:
    """The newest telemetry row: after two words, kind and count."""
    count = int(np.frombuffer(message, "<u4", 1, offset=4)[0])
    return np.frombuffer(message, layout, count, offset=8)[-1]


def read_plot(message: bytes) -> Plot:
    """The bins of a PLOT message: four words, times, channels, then lows and highs row by row."""
    _, count, columns, first = map(int, np.frombuffer(message, "<u4", 4))
    at = 16
    t = np.frombuffer(message, "<f8", count, offset=at)
    channels = np.frombuffer(message, "<u4", columns, offset=(at := at + t.nbytes))
    low = np.frombuffer(message, "<f4", count * columns, offset=(at := at + channels.nbytes))
    high = np.frombuffer(message, "<f4", count * columns, offset=at + low.nbytes)
    return Plot(first, t, channels, low.reshape(count, columns), high.reshape(count, columns))


def read_text(message: str) -> dict[str, Any]:
    """A JSON message; its `type` says what it is."""
    return json.loads(message)
