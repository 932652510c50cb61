"""All that a viewer may ask: what the OpenAPI says a viewer's session is enough for, and what it does not describe."""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple
from urllib.parse import urlencode

from server.access.security import SESSION

READ = "get"
VALUES = {"id": "none", "name": "circle_1hz", "key": "none", "seat": "abcdefgh", "role": "reference"}
"""Of the paths; `asked` is told the id of a recording that is there."""
QUERIES: dict[str, dict[str, object]] = {
    "/api/recordings/{id}/export": {"format": "csv"},
    "/api/history.csv": {"from": 0, "to": 1e12, "channels": "energy"},
}
_DRAWING = {
    "name": "flood",
    "points": [[0.2, 0.002 * i] for i in range(20)],
    "times": None,
    "closed": False,
    "smoothing": 0.0,
    "timing": {"kind": "duration", "duration": 5},
    "outside": "project",
    "pieces": None,
}
_TABLE = "t,x,y\n" + "".join(f"{0.01 * n:.2f},0.2,{1e-4 * n:.4f}\n" for n in range(300))
BODIES: dict[str, object] = {
    "plan_drawing": _DRAWING,
    "text_path": {"text": "Flood", "height": 0.02},
    "import_path": _TABLE,
    "propose_path": _TABLE,
    "preview": {"reference": "circle_1hz"},
    "preview_parts": {"drawing": _DRAWING},
    "make_export": {"format": "csv"},
}
"""By operation, those that cost the server most; whoever needs another gets an empty one, which is refused."""
PAGES = ("/", "/rerun/", "/rerun/re_viewer_bg.wasm", "/viser", "/viser/", "/viser/seat/abcdefgh/", "/api/openapi.json")
"""What OpenAPI does not describe."""
SPARED = ("command", "sign_out")
"""The E-STOP itself, and what would end the session that asks."""


class Asked(NamedTuple):
    """A request: `body` is JSON, or the text of a table."""

    method: str
    path: str
    body: object = None

    @property
    def name(self) -> str:
        """Method and path, without query."""
        return f"{self.method} {self.path.partition('?')[0]}"


def asked(described: dict[str, Any], recording: str) -> list[Asked]:
    """Of a server that describes itself so (OpenAPI), with the id of a recording that it has or "none"."""
    return [*_pages(), *_operations(described["paths"], VALUES | {"id": recording})]


def _pages() -> Iterator[Asked]:
    return (Asked("GET", path) for path in PAGES)


def _operations(paths: dict[str, dict[str, Any]], values: dict[str, str]) -> Iterator[Asked]:
    for path, methods in paths.items():
        for method, operation in methods.items():
            name = operation["operationId"]
            if _is_open(method, operation) and name not in SPARED:
                query = f"?{urlencode(QUERIES[path])}" if path in QUERIES and method == READ else ""
                body = None if method == READ else BODIES.get(name, {})
                yield Asked(method.upper(), re.sub(r"{(\w+)}", lambda m: values[m[1]], path) + query, body)


def _is_open(method: str, operation: dict[str, Any]) -> bool:
    return method == READ or any(way.get(SESSION) == ["viewer"] for way in operation.get("security", ()))
