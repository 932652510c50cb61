"""The template of docs/drivers.md and its far end, as another package that is installed has them."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from controller.drivers.conformance.suite import CAPTURE, FIRST, LAST, VALVES
from controller.drivers.registry import driver_class
from controller.errors import ParameterError
from controller.system.origin import ROOT
from controller.virtual.registry import capture_peer, valve_peer
from server.cli.drivers import app
from tests.controller.drivers.conformance.labboard import DRIVER, PAGE, PEER, install

run = CliRunner()
WIDE = {"COLUMNS": "200"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    install(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in ("labboard", "labboard.driver", "labboard.peer"):
        sys.modules.pop(name, None)


def test_the_template_and_its_far_end_are_short() -> None:
    assert len(DRIVER.splitlines()) <= 60 and len(PEER.splitlines()) <= 90


def test_the_template_passes_every_check_against_the_far_end_of_its_package(folder: Path) -> None:
    done = run.invoke(app, ["check", "labboard"], env=WIDE)
    assert done.exit_code == 0, done.output
    assert f"{len({**FIRST, **VALVES, **LAST})} shown, 0 not shown, 0 failed" in done.output
    listed = run.invoke(app, ["list"], env=WIDE).output
    assert re.search(r"labboard +valves +yes +labboard\.driver:LabBoard", listed)


def test_a_far_end_that_lacks_what_none_does_without_is_refused_by_name(folder: Path) -> None:
    (folder / "labboard" / "peer.py").write_text("class LabPeer:\n    def plug(self): ...\n    def close(self): ...\n")
    with pytest.raises(ParameterError, match=r"the peer of driver labboard, .*LabPeer, has no options, unplug"):
        valve_peer("labboard", {}, lambda: None, lambda drive: None)  # type: ignore[arg-type,return-value]
    (folder / "labboard-1.0.dist-info" / "entry_points.txt").write_text(
        "[tendril.drivers]\nlabboard = labboard.driver:LabBoard\n[tendril.peers]\nlabboard = labboard.peer:Other\n"
    )
    with pytest.raises(ParameterError, match=r"the peer of driver labboard does not load: labboard\.peer:Other"):
        valve_peer("labboard", {}, lambda: None, lambda drive: None)  # type: ignore[arg-type,return-value]


def test_a_far_end_stands_for_no_board_at_another_machine(folder: Path) -> None:
    with pytest.raises(ParameterError, match=r"valves\.options\.host = 192\.168\.1\.3: a virtual rig is at 127"):
        valve_peer("labboard", {"host": "192.168.1.3"}, lambda: None, lambda drive: None)  # type: ignore[arg-type,return-value]


def test_who_has_no_far_end_is_told_how_to_bring_one() -> None:
    with pytest.raises(ParameterError, match=r'only natnet, json can .*entry point "tendril\.peers"'):
        capture_peer("lsl", {})


def test_the_page_names_every_check() -> None:
    named = re.findall(r"^\| ([a-z ]+?)(?: \((?:capture|valves)\))? \| .* \|$", PAGE, re.MULTILINE)
    assert {*FIRST, *CAPTURE, *VALVES, *LAST} <= set(named)


@pytest.mark.parametrize(("driver", "page"), [("modbus", "modbus"), ("nidaq", "modbus"), ("udp", "udp")])
def test_the_pages_name_every_option(driver: str, page: str) -> None:
    text = (ROOT / "docs" / f"{page}.md").read_text()
    missing = [name for name in driver_class(driver).Options.model_fields if f"`{name}`" not in text]
    assert missing == []
