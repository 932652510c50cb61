"""The command line: a user's mistake is answered in one line that names it."""

import csv
import importlib.util
import inspect
import io
import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from rich.console import Console
from typer.main import get_command
from typer.testing import CliRunner

import server.cli.bench
import server.cli.main
from controller.errors import TendrilError
from controller.research.bench.bench import time_beside_mujoco
from controller.schema.actuator import PRESETS
from controller.schema.fit import TWIN
from controller.system.origin import ROOT, our_version
from server.app.listening import listen
from server.cli.main import app, main
from server.cli.typed import controller_of

FILE = str(ROOT / "docs" / "examples" / "rig.toml")
ONLY_THERE = f"{FILE} says which actuator is driven"
TENDRIL = Path(sys.executable).parent / "tendril"


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["rig", "--actuator", "P9"], "actuator = 'P9' is not one of P1, P2, P3"),
        (
            ["rig", "--rods", "20", "--integrator", "rk4"],
            "dt = 0.001 s is too long for RK4 with this actuator and rods = 20",
        ),
        (["bench", "--quick", "--json", "/nowhere/figures.json"], "/nowhere/figures.json cannot be written"),
        (["rig", "--actuator", "[/odd] [red].toml"], "[/odd] [red].toml cannot be read"),
        (["up", "--port", "99999"], "port = 99999: Input should be less than or equal to 65535"),
        (["serve", "--rig", "no spaces"], "rig = no spaces: 1 to 40 letters"),
        (["up", "--rig", FILE, "--actuator", "P2"], f"--actuator P2: {ONLY_THERE}"),
        (["up", "--rig", FILE, "--plant", "cosserat"], f"--plant cosserat: {ONLY_THERE}"),
        (["rig", "--rig", FILE, "--rods", "10"], f"--rods 10: {ONLY_THERE}"),
        (["rig", "--integrator", "rk4", "--rig", FILE], f"--integrator rk4: {ONLY_THERE}"),
        (
            ["serve", "--endpoint", "tcp/1.2.3.4:7447", "--link-tls", "certificates"],
            "--link-tls certificates: is for an endpoint tls/..., and --endpoint is tcp/1.2.3.4:7447",
        ),
        (["rig", "--link-tls", "certificates"], "--link-tls certificates: is for an endpoint tls/..., and --listen is"),
        (["reach", "P1", "--comments"], "--comments: is for the file of --csv"),
        (
            ["track", "--reference", "path.csv", "--out", "run.parquet", "--comments"],
            "--comments: is for --out FILE.csv, not run.parquet",
        ),
        (["drivers", "check", "modbus", "--drive"], "--drive: is for your own device, and this is the virtual peer"),
        (["faults", "--only", "page-busy", "--quick"], "only = page-busy: none of these is among"),
    ],
)
def test_a_wrong_value_is_named_in_one_line(
    arguments: list[str], complaint: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["tendril", *arguments])
    with pytest.raises(SystemExit, match=r"^1$"):
        main()
    said = capsys.readouterr().err
    assert complaint in said and len(said.splitlines()) == 1


@pytest.mark.process
def test_the_command_itself_ends_with_that_line_and_code_1() -> None:
    done = subprocess.run([TENDRIL, "rig", "--actuator", "P9"], capture_output=True, text=True, timeout=60)
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1)
    assert "actuator = 'P9' is not one of P1, P2, P3" in done.stderr


def test_a_port_in_use_is_named() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(TendrilError, match=f"port = {port}: Address already in use"):
            listen("127.0.0.1", port)


def commands(group: Any, *path: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command by the words that call it."""
    yield path, group
    for name, command in getattr(group, "commands", {}).items():
        yield from commands(command, *path, name)


ALL = dict(commands(get_command(app)))


@pytest.mark.parametrize("words", ALL, ids=" ".join)
def test_help_says_all_that_it_was_given_brackets_too(words: tuple[str, ...]) -> None:
    shown = CliRunner(env={"COLUMNS": "300"}).invoke(app, [*words, "--help"]).output
    plain = _plain(shown)
    for parameter in ALL[words].params:
        assert _plain(getattr(parameter, "help", None) or "") in plain
    assert _plain(inspect.cleandoc(ALL[words].help or "").split("\n\n")[0]) in plain


def _plain(text: str) -> str:
    """Without what Markdown, the frame and its width make of it."""
    return " ".join(text.replace("`", "").replace("│", " ").split())


def test_an_option_has_one_meaning_and_one_name_in_every_command() -> None:
    folders = {words for words, command in ALL.items() for one in command.params if "--folder" in one.opts}
    assert {("up",), ("serve",), ("recordings", "ls"), ("recordings", "import")} <= folders
    assert all("--recordings" in one.opts for words in folders for one in ALL[words].params if "--folder" in one.opts)


def test_the_observer_of_the_papers_actuators_has_the_fits_inertia_unless_told_otherwise() -> None:
    own = PRESETS["P2"].model_copy(update={"name": "Own"})
    for actuator, said, integrator, kappa in [
        (PRESETS["P2"], None, "implicit", TWIN["kappa"]),
        (PRESETS["P2"], 1.0, "implicit", 1.0),
        (PRESETS["P2"], None, "rk4", 1.0),
        (own, None, "implicit", 1.0),
        (own, 7.0, "implicit", 7.0),
    ]:
        assert controller_of(actuator, said, 10, integrator).observer_kappa == kappa


@pytest.mark.process
def test_the_version_names_the_commit() -> None:
    here = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    shown = CliRunner().invoke(app, ["--version"])
    assert shown.exit_code == 0
    assert shown.output.startswith(f"tendril {our_version()}")
    assert here.returncode or f"(commit {here.stdout.strip()}" in shown.output


@pytest.mark.process
def test_python_m_server_is_the_same_command() -> None:
    done = subprocess.run([sys.executable, "-m", "server", "track", "--help"], capture_output=True, text=True)
    assert done.returncode == 0 and "Usage: tendril track" in done.stdout


def test_the_reach_of_an_actuator_is_said_and_written(tmp_path: Path) -> None:
    table, drawing = tmp_path / "reach.csv", tmp_path / "reach.svg"
    shown = CliRunner().invoke(app, ["reach", "P1", "--csv", str(table), "--svg", str(drawing)])
    assert shown.exit_code == 0 and "at rest the tip is at (253.0, 0.0) mm" in shown.output
    with table.open() as lines:
        head, *rows = csv.reader(lines)
    assert head == ["u_1 [N m]", "u_2 [N m]", "x [m]", "y [m]"]
    p = np.array(rows, float)[:, 2:]
    assert len(p) == 61 * 61 and f"x {1e3 * p[:, 0].min():.1f} to {1e3 * p[:, 0].max():.1f} mm" in shown.output
    assert ElementTree.parse(drawing).getroot().tag.endswith("svg")


def test_a_reach_that_nobody_could_write_is_refused_before_the_work(tmp_path: Path) -> None:
    missing = tmp_path / "no" / "reach.csv"
    assert isinstance(CliRunner().invoke(app, ["reach", "P1", "--csv", str(missing)]).exception, TendrilError)


def test_what_the_benchmark_lacks_is_said_before_its_work_and_the_rest_is_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    said, file = io.StringIO(), tmp_path / "figures.json"
    out = Console(file=said, width=200)
    live = {
        "loop": {"policy": "none", "ticks": 1, "seconds": 1.0, "lost": 0, "baseline_lost": 0}
        | {"lateness_us": dict.fromkeys(("p50", "p99", "p999", "max"), 1.0)},
        "recording": {"rows": 1, "gaps": 0},
        "page": "none",
    }

    def measured(seconds: float, told: object) -> dict[str, Any]:
        assert "left out: playwright is not installed" in said.getvalue()
        assert "left out: mujoco is not installed" in said.getvalue()
        return live

    def timed(quick: bool, told: object) -> dict[str, Any]:
        ours, theirs = time_beside_mujoco(1)
        numbers = dict.fromkeys(
            ("tick_us", "tick_n1000_us", "closed_loop_seconds", "closed_loop_seconds_per_second"), 1.0
        )
        ratios = {f"{part}_n1000_over_n10": 1.0 for part in ("rk4", "implicit", "tick")}
        beside = {"mujoco_step_us": theirs, "rk4_over_mujoco": None, "mujoco_tip_difference_m": None, "elastica": None}
        return {
            "rod_step_us": ours,
            "link": {"prove_us": 1.0, "judge_us": 1.0},
            "scaling": [],
            "ensemble": {"seconds_per_second": 1.0, "rk4_seconds_per_second": 1.0, "implicit_over_rk4": 1.0},
            **numbers,
            **ratios,
            **beside,
        }

    for name in ("mujoco", "playwright"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(server.cli.bench, "measure_live", measured)
    monkeypatch.setattr(server.cli.bench, "bench", timed)
    monkeypatch.setattr(server.cli.main, "out", out)
    assert CliRunner().invoke(app, ["bench", "--quick", "--json", str(file)]).exit_code == 0
    told = json.loads(file.read_text())
    assert told["mujoco_step_us"] is None and told["rod_step_us"] > 0.0 and told["page"] == "none"
    assert told["origin"]["version"] == our_version() and told["origin"]["actuators"][0]["name"] == "P1"
    assert "MuJoCo" not in said.getvalue().split("tendril bench")[1]
