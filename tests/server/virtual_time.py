"""An event loop whose clock jumps to the next thing to do: hours of waiting in a second, and nothing late."""

import asyncio
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any


class Inline(ThreadPoolExecutor):
    """Does everything at once: a thread would be ages late on such a clock."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **more: Any) -> Future[Any]:
        done: Future[Any] = Future()
        try:
            done.set_result(fn(*args, **more))
        except BaseException as error:
            done.set_exception(error)
        return done


class VirtualLoop(asyncio.SelectorEventLoop):
    """Its time stands still while anything is to be done."""

    def __init__(self) -> None:
        super().__init__()
        self._now = 1000.0
        self.before_jump: Callable[[], None] = lambda: None
        """Called when nothing is left to be done now; what it begins is done before time goes on."""
        select = self._selector.select  # type: ignore[attr-defined]

        def jump(timeout: float | None = None) -> Any:
            assert timeout is not None, "nothing would ever happen any more"
            if timeout > 0.0:
                self.before_jump()
                timeout = 0.0 if self._ready else timeout  # type: ignore[attr-defined]
            self._now += max(0.0, timeout)
            return select(0.0)

        self._selector.select = jump  # type: ignore[attr-defined]
        self.set_default_executor(Inline())

    def time(self) -> float:
        return self._now
