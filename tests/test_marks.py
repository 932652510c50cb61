"""What the marks of tests promise: an input that changes runs its tests, and no process starts unmarked."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests import keyed

pytest_plugins = ["pytester"]


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A module `tests/test_it.py` that imports `near`, which imports `far` in a function, and data beside."""
    files = {
        "tests/test_it.py": "from controller.ours.near import f\n",
        "tests/conftest.py": "",
        "controller/ours/__init__.py": "",
        "controller/ours/near.py": "def f():\n    from controller.ours import far\n    return far\n",
        "controller/ours/far.py": "program = ['-m', 'controller.ours.started']\n",
        "controller/ours/started.py": "",
        "controller/ours/presets/one.toml": "",
        "controller/ours/fit.toml": "",
        "controller/other.py": "",
        "data/one.csv": "1",
        "named.py": "from controller import (\n    other,\n)\n",
        keyed.ALWAYS: "numpy==1",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(keyed, "ROOT", tmp_path)
    return tmp_path


def key(tree: Path, *named: str) -> str:
    keyed.imported.cache_clear()
    return keyed.key(tree / "tests/test_it.py", named)


@pytest.mark.parametrize(
    "changed",
    [
        "tests/test_it.py",
        "tests/conftest.py",
        *(
            f"controller/ours/{name}"
            for name in ("__init__.py", "near.py", "far.py", "started.py", "presets/one.toml", "fit.toml")
        ),
        "data/one.csv",
        keyed.ALWAYS,
    ],
)
def test_every_input_is_in_the_key(changed: str, tree: Path) -> None:
    before = key(tree, "data")
    (tree / changed).write_text((tree / changed).read_text() + "# changed\n")
    assert key(tree, "data") != before


def test_what_a_named_program_imports_is_an_input_and_what_nothing_names_is_none(tree: Path) -> None:
    plain, named = key(tree), key(tree, "named.py")
    (tree / "controller/other.py").write_text("# changed")
    assert key(tree) == plain
    assert key(tree, "named.py") != named
    (tree / "data/two.csv").write_text("2")
    assert key(tree, "data") != key(tree, "data/one.csv")
    both = key(tree, "data")
    (tree / "data/page.test.ts").write_text("test")
    assert key(tree, "data") == both
    with pytest.raises(pytest.UsageError, match=r"gone\.py names no file"):
        key(tree, "gone.py")


def test_without_imports_only_what_is_named_counts(tree: Path) -> None:
    def found() -> str:
        return keyed.key(tree / "tests/test_it.py", ["controller/ours"], imports=False)

    before = found()
    (tree / "controller/other.py").write_text("# changed")
    assert found() == before
    (tree / "controller/ours/far.py").write_text("# changed")
    assert found() != before


CASES = """
import pytest
pytestmark = pytest.mark.keyed()
def test_one(): pass
def test_two(): assert {right}
"""


def ran(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, *more: str, right: bool = True) -> dict[str, int]:
    """Outcomes of keyed tests in a tree of their own."""
    pytester.makepyfile(test_it=CASES.format(right=right))
    (pytester.path / keyed.ALWAYS).parent.mkdir(exist_ok=True)
    (pytester.path / keyed.ALWAYS).touch()
    monkeypatch.setattr(keyed, "ROOT", pytester.path)
    monkeypatch.setattr(keyed, "PASSED", pytester.path / "passed.json")
    keyed.imported.cache_clear()
    plugin = keyed.Keyed("--renew" in more, whole=True)
    done = pytester.inline_run("-p", "no:cacheprovider", "-p", "no:asyncio", plugins=[plugin])
    found = dict(zip(("passed", "skipped", "failed"), map(len, done.listoutcomes()), strict=True))
    return {name: count for name, count in found.items() if count}


def test_a_module_s_marks_are_read_without_importing_it(tmp_path: Path) -> None:
    (module := tmp_path / "test_it.py").write_text(
        "raise SystemExit\npytestmark = [pytest.mark.alone, pytest.mark.keyed('a', imports=False)]\n"
        "@pytest.mark.keyed('b')\ndef test_it(): pass\n"
    )
    assert keyed.declared(module) == ({"a", "b"}, False, ["alone", "keyed"])
    (other := tmp_path / "test_other.py").write_text("@pytest.mark.keyed('b')\ndef test_it(): pass\n")
    assert keyed.declared(other) == ({"b"}, True, []), "not all of its tests are keyed"


def test_what_passed_is_skipped_until_an_input_changes(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert ran(pytester, monkeypatch) == {"passed": 2}, "nothing is kept without --renew"
    assert ran(pytester, monkeypatch, "--renew") == {"passed": 2}
    assert ran(pytester, monkeypatch) == {"skipped": 1}, "the module is not even imported"
    assert ran(pytester, monkeypatch, right=False) == {"passed": 1, "failed": 1}
    assert ran(pytester, monkeypatch, "--renew", right=False) == {"passed": 1, "failed": 1}
    assert json.loads(keyed.PASSED.read_text()) == {}, "what failed is not kept"


@pytest.mark.process
def test_a_test_that_starts_a_process_unmarked_fails(tmp_path: Path) -> None:
    (tmp_path / "asking_library.py").write_text("import subprocess\nsubprocess.run(['true'])\n")
    tests = tmp_path / "test_starts.py"
    tests.write_text(
        "import pytest, subprocess, multiprocessing as m\n"
        "def test_plain(): subprocess.run(['true'])\n"
        "def test_spawned():\n    p = m.get_context('spawn').Process(target=print)\n    p.start()\n    p.join()\n"
        "@pytest.mark.process\ndef test_marked(): subprocess.run(['true'])\n"
        "def test_none(): pass\n"
        "def test_imports(): import asking_library\n"
    )
    plugin = ["-p", "tests.conftest", "-p", "no:cacheprovider", "--rootdir", str(tmp_path), "-c", "/dev/null"]
    program = [sys.executable, "-m", "pytest", "-q", *plugin, str(tests)]
    done = subprocess.run(program, capture_output=True, text=True, cwd=keyed.ROOT)
    assert re.search(r"5 passed.*2 errors", done.stdout), done.stdout
    assert set(re.findall(r"^ERROR .*::test_(\w+)", done.stdout, re.MULTILINE)) == {"plain", "spawned"}
    assert done.stdout.count("it starts a process and is not marked so") >= 2
