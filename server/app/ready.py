"""How a started process tells its address to the process that started it: a small file, written whole."""

import os
from collections.abc import Callable
from pathlib import Path

from controller.schema.layout import Model
from controller.system.whole_file import write_whole


class Addresses(Model):
    """Where browsers find the page; each address holds an access token."""

    operator: str
    viewer: str


class ServerReady(Model):
    """What a server says when it answers: the addresses hold the access tokens, so the file is the user's alone."""

    url: str
    """The operator's."""
    viewer_url: str
    process: int


class UpReady(Model):
    """What `tendril up` says when the page can be opened."""

    url: str
    """The operator's."""
    viewer_url: str
    rig_process: int
    server_process: int


def write_ready(path: Path, value: Model) -> None:
    """Put `value` as JSON at `path` by rename: a reader sees all of it or nothing."""
    write_whole(path, value.model_dump_json(), lasting=False)


def announce_to(path: Path) -> Callable[[Addresses], None]:
    """A listener for `run_server` that writes a `ServerReady` to `path`."""
    return lambda at: write_ready(path, ServerReady(url=at.operator, viewer_url=at.viewer, process=os.getpid()))
