"""How `tendril up` says where the page is: the access tokens reach its user, and no other one of the machine."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

PRINT = """
from server.app import up
from server.app.ready import ServerReady
up.announce(ServerReady(url="http://here/?token=s3cret", viewer_url="http://here/?token=l00k", process=1), None)
"""
OPEN = """
import sys
from pathlib import Path
from server.app import up
from server.app.ready import ServerReady
up.announce(ServerReady(url="http://here/?token=s3cret", viewer_url="http://here/", process=1), Path(sys.argv[1]))
"""


@pytest.mark.parametrize(("mode", "shown"), [(0o644, False), (0o640, False), (0o600, True)])
def test_tokens_are_printed_into_no_file_that_others_read(mode: int, shown: bool, tmp_path: Path) -> None:
    path = tmp_path / "up.log"
    path.touch(mode)
    with path.open("w") as file:
        subprocess.run([sys.executable, "-c", PRINT], stdout=file, check=True)
    said = path.read_text()
    assert ("s3cret" in said, "l00k" in said) == (shown, shown)
    assert "http://here" in said and "tendril token" in said


def test_nor_into_a_pipe_but_on_a_terminal() -> None:
    done = subprocess.run([sys.executable, "-c", PRINT], capture_output=True, text=True, check=True)
    assert "s3cret" not in done.stdout + done.stderr
    ours, theirs = os.openpty()
    subprocess.run([sys.executable, "-c", PRINT], stdout=theirs, stderr=subprocess.DEVNULL, check=True)
    os.close(theirs)
    assert b"s3cret" in os.read(ours, 10_000)
    os.close(ours)


def test_no_token_stands_in_the_command_line_of_the_browser_and_it_finds_the_page_all_the_same(tmp_path: Path) -> None:
    browser, page = tmp_path / "browser", tmp_path / "open.html"
    browser.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/asked\n')
    browser.chmod(0o700)
    environment = os.environ | {"BROWSER": str(browser), "DISPLAY": ":0"}
    subprocess.run([sys.executable, "-c", OPEN, str(page)], env=environment, capture_output=True, check=True)
    assert (tmp_path / "asked").read_text().strip() == page.as_uri()
    assert 'content="0;url=http://here/?token=s3cret"' in page.read_text()
    assert page.stat().st_mode & 0o077 == 0
