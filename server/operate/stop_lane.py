"""The E-STOP by HTTP: acted on as its last byte comes in, before the turns of the event loop that its answer takes."""

from collections.abc import Callable
from concurrent.futures import Future

from pydantic import ValidationError
from starlette.datastructures import Headers
from starlette.types import Scope

from controller.schema.messages import CommandReply
from server.access.gate import COMMAND
from server.http.who import Identity
from server.operate.messages import CommandBody

PRESSED = "pressed"
"""In the state of a request that was an E-STOP: the future of its answer."""
BODY_MAX_BYTES = 256
"""Bytes of an E-STOP's body."""


class StopLane:
    """Told of every request that is whole. `admitted` says who asks, as the gate judges, without its bookkeeping."""

    def __init__(
        self, admitted: Callable[[Scope], Identity | None], stop: "Callable[[str], Future[CommandReply]]"
    ) -> None:
        self._admitted, self._stop = admitted, stop

    def __call__(self, scope: Scope, body: bytes) -> None:
        """Stop, if that is what an admitted request asks for; its route answers as ever."""
        if scope.get("path") != COMMAND or scope["method"] != "POST" or not _is_stop(scope, body):
            return
        if who := self._admitted(scope):
            scope["state"][PRESSED] = self._stop(who.described)


def _is_stop(scope: Scope, body: bytes) -> bool:
    kind = Headers(scope=scope).get("content-type", "").partition(";")[0].strip().lower()
    if len(body) > BODY_MAX_BYTES or b"e_stop" not in body or kind != "application/json":
        return False
    try:
        return CommandBody.model_validate_json(body).request == "e_stop"
    except ValidationError:
        return False
