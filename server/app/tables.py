"""Tables of docs/api.md and docs/live.md: routes, and how a telemetry row lies in memory; `make schema` renews them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from controller.schema.layout import fields
from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Mode
from controller.text.markdown import filled, table
from server.access.security import SESSION, TOKEN
from server.app.app import openapi_schema

API, LIVE = Path("docs/api.md"), Path("docs/live.md")
_WHO = {"viewer": "signed in", "operator": "operator", "lease": "holder of the lease"}


def routes() -> str:
    """Every route of the OpenAPI: method and path, who may, what it does."""
    rows = []
    for path, methods in openapi_schema()["paths"].items():
        for method, operation in methods.items():
            does = " ".join(operation["description"].split("\n\n")[0].split()).replace("|", "\\|")
            rows.append([f"`{method.upper()} {path}`", _who(operation), does])
    return table(["route", "who", "does"], rows)


def layout() -> str:
    """Every number of a telemetry row: where it begins [bytes], and what it is; and what the codes mean."""
    rows = []
    for one in fields(Telemetry):
        shape, unit = " x ".join(map(str, one.shape)), "" if one.unit == "1" else one.unit
        rows.append([str(one.offset), f"`{one.name}`", one.type, shape, unit])
    codes = [f"`{kind.__name__.lower()}`: {', '.join(f'{one} {one.name}' for one in kind)}." for kind in (Mode, Cause)]
    return table(["offset", "field", "type", "shape", "unit"], rows) + "\n" + "\n\n".join(codes) + "\n"


def _who(operation: dict[str, Any]) -> str:
    ways: list[dict[str, list[str]]] = operation.get("security", [{}])
    return "; ".join(_words(ways))


def _words(ways: list[dict[str, list[str]]]) -> Iterator[str]:
    alone = len(ways) == 1
    for way in ways:
        if SESSION in way:
            yield _WHO[way[SESSION][0]]
        elif TOKEN in way:
            yield "with an access token"
        else:
            yield "anyone" if alone else "anyone on this machine"


if __name__ == "__main__":
    API.write_text(filled(API.read_text(), "routes", routes()))
    LIVE.write_text(filled(LIVE.read_text(), "layout", layout()))
