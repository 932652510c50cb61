"""What was refused, counted: a rising number is someone's mistake, or someone's attempt."""

from collections import Counter
from dataclasses import dataclass, field


@dataclass
class RefusedCounts:
    """Since this server started. Only the event loop counts."""

    requests: Counter[int] = field(default_factory=Counter)
    """Requests and sockets by the status of their answer, 400 and above."""
    messages: int = 0
    """Messages on live sockets."""
    signatures: int = 0
    """Cookies that this server did not sign, or not with its present token."""

    def answer(self, status: int) -> None:
        """Count an answer, if it is a refusal."""
        if status >= 400:
            self.requests[status] += 1
