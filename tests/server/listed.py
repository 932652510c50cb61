"""The list of recordings, for who asks for it again and again: a heavy request, which has a limit."""

import time
from typing import Any

from tests.server.live_server import Page, taken


def listed(page: Page) -> list[dict[str, Any]]:
    """All of them; asked for again as late as the answer says where that was too often."""
    while (answer := page.get("/api/recordings")).status_code == 429:
        time.sleep(float(answer.headers["retry-after"]))
    return list(taken(answer).json())
