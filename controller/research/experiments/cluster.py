"""The way to a Dask cluster (dask.distributed, the extra `cluster`), as an executor of the standard library.

The scheduler gives what a lost worker had to another one, results that lay on it included.
"""

from concurrent.futures import Executor, Future
from importlib import import_module
from typing import Any

from controller.errors import ParameterError, TendrilError
from controller.system.origin import install_command, our_version

CONNECT_SECONDS = 10.0
RETRIES = 2
"""How often a call that failed for the cluster's sake is made again."""


def connected(address: str) -> Executor:
    """An executor whose calls the workers of the scheduler at `address` ("tcp://host:8786") make.

    Raises ParameterError where dask.distributed is not installed or nothing answers at the address, and TendrilError
    for workers that have another version of Tendril, or none.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise ParameterError(f"--scheduler needs dask.distributed: {install_command('cluster')}") from error
    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ParameterError(f"scheduler = {address!r} does not answer: {error}") from error
    try:
        require_same(client.run(our_version, on_error="return"))
    except BaseException:
        client.close()
        raise
    return Cluster(client)


class Cluster(Executor):
    """Calls as futures of the standard library, made once each by the cluster's workers."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._calls: Executor = client.get_executor(pure=False, retries=RETRIES)

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """As of `Executor`."""
        return self._calls.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster as it is; what no one waits for any more is dropped there."""
        self._calls.shutdown(wait=wait and not cancel_futures)
        self._client.close()


def require_same(versions: dict[str, Any]) -> None:
    """Raise TendrilError unless each worker's version is ours."""
    ours = our_version()
    for worker, theirs in versions.items():
        if theirs != ours:
            raise TendrilError(f"worker {worker} has Tendril {theirs}, here it is {ours}")


def lost() -> tuple[type[BaseException], ...]:
    """What says that the cluster cannot do its work: a call whose workers died again and again, or no scheduler."""
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        return ()
    return distributed.KilledWorker, distributed.comm.CommClosedError
