"""A request or socket under the audit's eyes."""

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.log.audit import Asker, Audit, heard_by

STARTS = ("http.response.start", "websocket.http.response.start")
"""Messages that carry the status of an answer."""


class Audited:
    """Runs `app`, and has the audit log say what came of it."""

    def __init__(self, app: ASGIApp, audit: Audit, asker: Asker) -> None:
        self._app, self._audit, self._asker = app, audit, asker
        self._said: list[str] = []
        self._noted = False

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Run to the end."""

        async def watched(message: Message) -> None:
            if message["type"] in STARTS:
                self._note(message["status"])
            elif message["type"] == "websocket.accept":
                self._note(101, "opened")
            elif message["type"] == "websocket.close" and not self._noted:
                self._note(403)
            await send(message)

        with heard_by(self._hear):
            await self._app(scope, receive, watched)

    def _hear(self, text: str) -> None:
        """Before the answer it explains the answer; on an open socket it is an act of its own."""
        if self._noted:
            self._audit.note(self._asker, 101, text)
        else:
            self._said.append(text)

    def _note(self, status: int, detail: str = "") -> None:
        self._noted = True
        self._audit.note(self._asker, status, detail or "; ".join(self._said))
