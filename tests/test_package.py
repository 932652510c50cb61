"""What the package says of itself, wherever it is read."""

import re
import runpy
import subprocess
import sys
import tomllib
from importlib.metadata import metadata, requires
from pathlib import Path

import pytest
import yaml

from controller.system.origin import NAME, install_command, our_version

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_page_of_the_package_index_links_nothing_that_is_only_in_the_repository() -> None:
    page = runpy.run_path(str(ROOT / ".ci" / "package_page.py"))["package_page"]
    shown = page((ROOT / "README.md").read_text())
    assert re.findall(r"\]\((?!https?://)[^)]*\)", shown) == []
    assert "two machines (`tendril docs two-machines`)" in shown and "| Eq. KKT |" in shown
    assert metadata(NAME)["Description"].strip() == shown.strip()


def test_no_hint_and_no_extra_fetches_a_strangers_package() -> None:
    wanted = [text for extra in PROJECT["optional-dependencies"].values() for text in extra]
    assert NAME == PROJECT["name"] != "tendril" and f"{NAME}[bench]" in wanted
    assert not any(re.match(r"tendril\b(?!-softrobotics)", text) for text in wanted)
    for path in (path for folder in ("controller", "recordings", "server") for path in (ROOT / folder).rglob("*.py")):
        assert not re.search(r"install '?tendril", path.read_text()), path


@pytest.mark.parametrize(
    ("extra", "package"), [("bench", "mujoco"), ("bench", "playwright"), ("engines", "pyelastica")]
)
def test_what_an_extra_lacks_is_installed_into_this_very_environment(extra: str, package: str) -> None:
    wanted, *_ = [text.split(";")[0] for text in requires(NAME) or () if text.startswith(package)]
    assert "-m pip install" in install_command(extra) and f"'{wanted}'" in install_command(extra)


def test_version_and_names_are_the_same_in_citation_changelog_and_licence() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert cited["version"] == PROJECT["version"] == our_version()
    assert f"\n## {our_version()} - {cited['date-released']}\n" in (ROOT / "CHANGELOG.md").read_text()
    (author,) = PROJECT["authors"]
    assert cited["authors"] == [author] and author["name"] in (ROOT / "LICENSE").read_text()
    (paper,) = cited["references"]
    assert [one["family-names"] for one in paper["authors"]] == ["Kumar", "Gaston", "Rucker", "Barth"]


@pytest.mark.parametrize("package", ["controller", "recordings", "server"])
def test_who_imports_us_gets_our_types(package: str) -> None:
    assert (ROOT / package / "py.typed").exists()


def test_the_changelog_is_read_a_line_at_a_time() -> None:
    lines = (ROOT / "CHANGELOG.md").read_text().splitlines()
    assert [line for line in lines if len(line) > 102] == []  # "- " and at most 100 characters
    entries = [line for line in lines if line and not line.startswith("#")][1:]
    assert entries and all(line.startswith("- ") for line in entries)


WITHOUT = "import sys; sys.modules |= dict.fromkeys(('cma', 'matplotlib')); "
"""As where the extra `research` is not installed."""


@pytest.mark.process
def test_rig_server_and_recordings_work_without_what_research_needs() -> None:
    core = "controller.realtime.rig, controller.simulation.acceptance, recordings.exporting.export, server.app.services"
    subprocess.run([sys.executable, "-c", f"{WITHOUT}import {core}, server.cli.main"], check=True, cwd=ROOT)


@pytest.mark.process
@pytest.mark.parametrize("command", ["calibrate", "reach P1 --svg reach.svg"])
def test_a_command_that_lacks_an_extra_names_it_in_one_line(command: str, tmp_path: Path) -> None:
    asked = f"{WITHOUT}sys.path.insert(0, {str(ROOT)!r}); sys.argv = ['tendril', *{command.split()}]; "
    run = [sys.executable, "-c", f"{asked}from server.cli.main import main; main()"]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1
    assert "this command needs" in done.stderr and "pip install" in done.stderr
