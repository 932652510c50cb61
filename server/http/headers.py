"""Headers of every answer: security, and when it was given."""

import re
import time

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import Message, Scope, Send

from server.http.frames import ISOLATION

STARTS = ("http.response.start", "websocket.http.response.start")
"""Messages that carry the status and the headers of an answer."""
_HOST = re.compile(r"[\w.:\[\]-]+")
_FOREIGN = ("/viser", "/rerun")
_UNUSED = (
    "accelerometer",
    "bluetooth",
    "camera",
    "display-capture",
    "fullscreen",
    "geolocation",
    "gyroscope",
    "hid",
    "magnetometer",
    "microphone",
    "midi",
    "payment",
    "publickey-credentials-get",
    "screen-wake-lock",
    "serial",
    "usb",
    "xr-spatial-tracking",
)
"""What no page may ask a browser for: a frame that fills the screen would cover the E-STOP. Ours asks for a gamepad."""
_PERMISSIONS = ", ".join(["gamepad=(self)", *(f"{name}=()" for name in _UNUSED)])
TIME = "tendril-time"
"""When the answer was given, by `server_time`."""
_BEGAN = time.monotonic()
HSTS = "max-age=15552000"
"""Half a year, this host alone: other servers of its domain may have no TLS."""


def server_time() -> float:
    """Time since this server began [s]: an answer and a status on a socket may overtake each other on their way."""
    return time.monotonic() - _BEGAN


def with_headers(scope: Scope, send: Send) -> Send:
    """`send`, with these headers on what is answered."""

    async def send_with_headers(message: Message) -> None:
        if message["type"] in STARTS:
            headers = MutableHeaders(scope=message)
            headers[TIME] = repr(server_time())
            for name, value in _security(scope).items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers


def _security(scope: Scope) -> dict[str, str]:
    foreign = scope["path"].startswith(_FOREIGN)
    encrypted = scope["scheme"] in ("https", "wss")
    return {
        "content-security-policy": _policy(scope, foreign, encrypted),
        "cross-origin-opener-policy": "same-origin",
        "cross-origin-embedder-policy": "require-corp",
        "cross-origin-resource-policy": "same-origin",
        "permissions-policy": _PERMISSIONS,
        "referrer-policy": "no-referrer",
        "x-content-type-options": "nosniff",
        "cache-control": "no-store" if scope["path"].startswith("/api") else "no-cache",
        **(ISOLATION if foreign else {}),
        **({"strict-transport-security": HSTS} if encrypted else {}),
    }


def _policy(scope: Scope, foreign: bool, encrypted: bool) -> str:
    """Viser's and rerun's own pages hold inline scripts, compile wasm and use blobs; ours only styles itself."""
    host = Headers(scope=scope).get("host", "")
    sockets = f" {'wss' if encrypted else 'ws'}://{host}" if _HOST.fullmatch(host) else ""
    loose = " data: blob:" if foreign else ""
    policy = {
        "default-src": "'self'",
        "script-src": "'self' 'unsafe-inline' 'wasm-unsafe-eval' blob:" if foreign else "'self'",
        "worker-src": "'self' blob:" if foreign else "'self'",
        "style-src": "'self' 'unsafe-inline'",
        "img-src": "'self' data: blob:",
        "connect-src": f"'self'{loose}{sockets}",
        "font-src": "'self' data:" if foreign else "'self'",
        "object-src": "'none'",
        "base-uri": "'self'" if foreign else "'none'",
        "form-action": "'self'",
        "frame-ancestors": "'self'",
    }
    return "; ".join(f"{name} {value}" for name, value in policy.items())
