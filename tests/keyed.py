"""What hardly ever changes and takes long is tested once for its inputs: their hash is kept when the tests passed.

The inputs of a module whose tests are marked `keyed` are its own file, the fixtures above it (conftest.py), all that it
imports of ours, however far down, with the data that lie in those rooms, the files that the marks name (a Python file
with all that it imports, a folder with all that it holds), and the versions of the libraries. While their hash is the
one in PASSED they are skipped. `make renew`, with which `make test-long` begins, runs them and keeps the new one. With
`imports=False` only what is named counts: for a test of the whole product, whose every other room has tests that are
always run. Long tests are never skipped.
"""

import ast
import hashlib
import json
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PASSED = ROOT / "tests" / "passed.json"
ALWAYS = ".ci/requirements.lock"
"""An input of every test."""
IMPORT = re.compile(r"^[ \t]*(?:from ([\w.]+) import (\([^)]*\)|.+)|import ([\w.]+))", re.MULTILINE)
STARTED = re.compile(r"""["']((?:controller|recordings|server|tests)(?:\.\w+)+)["']""")
"""What is imported or started by its name in a text (`-m`)."""
LEFT_OUT = ("__pycache__", "server/static/", "recordings/data/", ".test.ts")
"""What is built, or recorded, among the sources, and the page's own tests, which are no part of it."""
PACKAGES = ("controller", "recordings", "server")
DISPATCHES = "server/cli/main.py"
"""Imports in its functions begin each command of the product: a test that gives one names what that command imports."""
UNCHANGED = "passed with the same inputs (tests/passed.json); make renew runs it"


@cache
def imported(file: Path) -> frozenset[Path]:
    """Files of ours that `file` names in its imports, those inside its functions too, and modules that it starts."""
    found: set[Path] = set()
    text = file.read_text()
    if file == ROOT / DISPATCHES:
        text = re.sub(r"^[ \t].*", "", text, flags=re.MULTILINE)
    for package, names, module in (*IMPORT.findall(text), *(("", "", one) for one in STARTED.findall(text))):
        whole = package or module
        for one in (whole, *(f"{whole}.{name}" for name in re.findall(r"\w+", names))):
            place = ROOT.joinpath(*one.split("."))
            found |= {place.with_suffix(".py"), place / "__init__.py"}
    return frozenset(one for one in found if one.is_file())


def closure(files: Iterable[Path]) -> set[Path]:
    """`files`, and what they import of ours, however far down."""
    found: set[Path] = set()
    left = list(files)
    while left:
        one = left.pop()
        if one not in found:
            found.add(one)
            left += imported(one) if one.suffix == ".py" else ()
    return found


def data_beside(files: Iterable[Path]) -> set[Path]:
    """What lies in the rooms of `files` and is no program: tables, presets, schemas; in their folders of data too."""
    rooms = {file.parent for file in files if file.relative_to(ROOT).parts[0] in PACKAGES}
    folders = {one for room in rooms - {ROOT / name for name in PACKAGES} for one in (room, *room.iterdir())}
    kept = [one for one in folders if one.is_dir() and (one in rooms or not any(one.glob("*.py")))]
    found = [file for one in kept if one.name != "__pycache__" for file in one.iterdir() if file.is_file()]
    return {file for file in found if file.suffix != ".py"}


def named(pattern: str) -> Iterator[Path]:
    """The files that a mark means by a file, a folder or a pattern: at least one."""
    found = [inner for one in ROOT.glob(pattern) for inner in (one.rglob("*") if one.is_dir() else [one])]
    kept = [one for one in found if one.is_file() and not any(part in str(one) for part in LEFT_OUT)]
    if not kept:
        raise pytest.UsageError(f"keyed: {pattern} names no file")
    yield from kept


def key(module: Path, patterns: Iterable[str], imports: bool = True) -> str:
    """Hash of all inputs of the keyed tests in `module`."""
    hashed = hashlib.sha256()
    files = {module, *(file for one in (ALWAYS, *patterns) for file in named(one))}
    if imports:
        files = closure(files)
        files |= data_beside(files)
    fixtures = (one / "conftest.py" for one in module.parents if one.is_relative_to(ROOT))
    files |= {one for one in fixtures if one.is_file()}
    for file in sorted(files):
        hashed.update(f"{file.relative_to(ROOT)}\n".encode() + hashlib.sha256(file.read_bytes()).digest())
    return hashed.hexdigest()[:16]


def name(item: pytest.Item) -> str:
    return str(item.path.relative_to(ROOT))


def passed() -> dict[str, str]:
    """Key with which the keyed tests of each module passed last."""
    return dict(json.loads(PASSED.read_text())) if PASSED.exists() else {}


def keys(items: Iterable[pytest.Item]) -> dict[str, str]:
    """Key of each module that has keyed tests."""
    modules = {item.path for item in items if item.get_closest_marker("keyed") and not isinstance(item, Skipped)}
    return {str(module.relative_to(ROOT)): key_of(module) for module in modules}


def key_of(module: Path) -> str:
    """Key of a module by the marks that are written in it."""
    patterns, imports, _ = declared(module)
    return key(module, sorted(patterns), imports)


@cache
def declared(module: Path) -> tuple[set[str], bool, list[str]]:
    """Inputs that the marks in a module name, whether its imports count, and our marks that all its tests have."""
    patterns: set[str] = set()
    imports, marks = True, []
    text = module.read_text()
    for node in ast.walk(ast.parse(text)) if "mark.keyed" in text else ():
        if isinstance(node, ast.Assign) and [ast.unparse(one) for one in node.targets] == ["pytestmark"]:
            marks = re.findall(r"pytest\.mark\.(keyed|alone|campaign|process|long)\b", ast.unparse(node.value))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "pytest.mark.keyed":
            patterns |= {ast.literal_eval(one) for one in node.args}
            imports = imports and all(ast.literal_eval(one.value) for one in node.keywords)
    return patterns, imports, marks


class Unchanged(pytest.File):
    """Instead of a module all of whose tests passed with the same inputs: it need not even be imported."""

    def collect(self) -> Iterator[pytest.Item]:
        skipped = Skipped.from_parent(self, name="unchanged")
        for mark in declared(self.path)[2]:
            skipped.add_marker(mark)
        yield skipped


class Skipped(pytest.Item):
    """Says so."""

    def runtest(self) -> None:
        pytest.skip(UNCHANGED)


class Keyed:
    """Skips what passed with the same inputs; with `renew` runs it, and keeps the keys of modules that passed."""

    def __init__(self, renew: bool, whole: bool) -> None:
        self._renew, self._whole = renew, whole
        self._keys: dict[str, str] = {}
        self._failed: set[str] = set()

    @pytest.hookimpl(tryfirst=True)
    def pytest_pycollect_makemodule(self, module_path: Path, parent: pytest.Collector) -> Unchanged | None:
        module = str(module_path.relative_to(ROOT)) if module_path.is_relative_to(ROOT) else ""
        if self._renew or not self._whole or module not in passed():
            return None
        same = "keyed" in declared(module_path)[2] and passed()[module] == key_of(module_path)
        return Unchanged.from_parent(parent, path=module_path) if same else None

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        found, kept = keys(items), passed()
        for item in items:
            if item.get_closest_marker("keyed") and not isinstance(item, Skipped):
                module = name(item)
                item.user_properties.append(("keyed", found[module]))
                if not self._renew and kept.get(module) == found[module]:
                    item.add_marker(pytest.mark.skip(reason=UNCHANGED))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if found := dict(report.user_properties).get("keyed"):
            module = report.nodeid.split("::")[0]
            self._keys[module] = str(found)
            if report.failed:
                self._failed.add(module)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        done = {module: key for module, key in self._keys.items() if module not in self._failed}
        if self._renew and self._whole and not hasattr(session.config, "workerinput"):
            kept = {module: key for module, key in passed().items() if (ROOT / module).exists()}
            kept = {module: key for module, key in kept.items() if module not in self._failed}
            PASSED.write_text(json.dumps(dict(sorted((kept | done).items())), indent=1) + "\n")
