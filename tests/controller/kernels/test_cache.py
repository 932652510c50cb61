"""Compiled kernels are kept for exactly the sources that they were made from."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import controller

ROOT = Path(controller.__file__).parent


def test_a_change_of_any_constant_that_kernels_import_makes_a_new_cache() -> None:
    """Else the loop would go on by the old table of states."""
    imported = set()
    for path in (ROOT / "kernels").rglob("*.py"):
        imported |= set(re.findall(r"^from controller\.([a-z_.]+) import", path.read_text(), re.MULTILINE))
    outside = {ROOT / f"{name.replace('.', '/')}.py" for name in imported if not name.startswith("kernels")}
    assert ROOT / "schema/states.py" in outside
    assert outside <= set(controller.compiled_sources())


@pytest.mark.process
@pytest.mark.parametrize("module", ["server.app.app", "server.cli.main", "controller.realtime.rig"])
def test_linear_algebra_has_no_threads_of_its_own(module: str) -> None:
    """They spin: beside another busy process a table of margins took ten minutes instead of one."""
    told = f"import os, {module}, scipy.linalg; print(len(os.listdir('/proc/self/task')))"
    plain = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    run = subprocess.run([sys.executable, "-c", told], env=plain, capture_output=True, text=True, check=True)
    assert run.stdout == "1\n"


def declared(folder: Path, cache: Path) -> subprocess.CompletedProcess[str]:
    """A process that compiles one small kernel of `folder`, or finds it in the cache."""
    program = folder / "program.py"
    program.write_text(
        "import controller\n"
        "from controller.kernels.compiled import kernel\n"
        "@kernel\n"
        "def twice(x):\n"
        "    return 2.0 * x\n"
        "assert twice(2.0) == 4.0\n"
        "print(sum(twice.stats.cache_hits.values()))\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT.parent)}
    return subprocess.run([sys.executable, program], env=environment, capture_output=True, text=True, check=True)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a cache that is found."""
    folder = tmp_path_factory.mktemp("compiled")
    assert [declared(folder, folder / "cache").stdout for _ in range(2)] == ["0\n", "1\n"]
    return folder


SHORT = {("index", "half"), ("code", "random")}
DAMAGES = [
    pytest.param(kind, damage, marks=[] if (kind, damage) in SHORT else pytest.mark.long)
    for kind in ("index", "code")
    for damage in ("half", "random", "pipe", "empty", "zeros", "folder")
]


@pytest.mark.process
@pytest.mark.parametrize(("kind", "damage"), DAMAGES)
def test_a_cache_that_is_damaged_is_compiled_again(kind: str, damage: str, compiled: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    shutil.copytree(compiled / "cache", cache)
    [path] = cache.rglob("*.nbi" if kind == "index" else "*.nbc")
    data = path.read_bytes()
    path.unlink()
    match damage:
        case "folder":
            path.mkdir()
        case "pipe":
            os.mkfifo(path)
        case _:
            half = data[: len(data) // 2]
            spoilt = {"empty": b"", "half": half, "zeros": half + bytes(len(data) - len(half)), "random": data[::-1]}
            path.write_bytes(spoilt[damage])
    done = declared(compiled, cache)
    assert (done.stdout, "cannot be used" in done.stderr) == ("0\n", True), done.stderr
    assert declared(compiled, cache).stdout == ("0\n" if damage == "folder" else "1\n")


@pytest.mark.process
def test_a_cache_folder_that_takes_nothing_is_used_as_a_copy(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file")
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment |= {"XDG_CACHE_HOME": str(tmp_path / "cache"), "PYTHONPATH": str(ROOT.parent)}
    program = "import controller, os; print(os.path.isdir(os.environ['NUMBA_CACHE_DIR']))"
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
