"""What a machine that stood still has broken is told apart from a defect: such a test is tried again, and it is said.

Tests run where other programs run, on machines that are paused for a second now and then: rigs latch, answers come
late, a page loses control, all rightly. A thread looks every 20 ms. Where a test fails and the thread was kept from
looking for longer than `STALL_S` meanwhile, the test has not judged anything. Any other failure counts at once.
"""

import threading
import time
from collections.abc import Callable, Iterator

import pytest
from _pytest.runner import runtestprotocol

LOOK_S = 0.02
STALL_S = 0.1
"""After as much a board's own watchdog vents. None in 40 s beside four programs that spin, on two cores (2026-11-28);
beside another product, whose loop is before all others, it may be 0.3 s."""
TRIES = 3
WITHIN_S = 100.0
"""A test that has taken longer is not tried again: what a test may take covers all of its tries."""
REPEATED = "repeated"
"""Name of the property of a test that was."""


class Watch:
    """A thread that notes when it was kept from looking."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._stalls: list[float] = []
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look, name="stalls", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        self._thread.join()

    def begin(self) -> None:
        """Forget what was."""
        self._stalls.clear()

    def longest(self) -> float:
        """Longest time since `begin` for which it was kept from looking [s]."""
        return max(self._stalls, default=0.0)

    def _look(self) -> None:
        before = self._now()
        while not self._over.wait(LOOK_S):
            now = self._now()
            if now - before - LOOK_S > STALL_S:
                self._stalls.append(now - before)
            before = now


def pytest_configure(config: pytest.Config) -> None:
    """Every session has it (`addopts` in pyproject.toml)."""
    config.pluginmanager.register(Stalls(Watch()))


class Stalls:
    """Tries again what failed while the machine stood still."""

    def __init__(self, watch: Watch) -> None:
        self._watch = watch

    def pytest_sessionstart(self) -> None:
        self._watch.start()

    def pytest_sessionfinish(self) -> None:
        self._watch.stop()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool:
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in self._tried(item, nextitem):
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def _tried(self, item: pytest.Item, nextitem: pytest.Item | None) -> list[pytest.TestReport]:
        end = time.monotonic() + WITHIN_S
        reports: list[pytest.TestReport] = []
        for left in reversed(range(TRIES)):
            self._watch.begin()
            reports = runtestprotocol(item, log=False, nextitem=nextitem)
            stall, failed = self._watch.longest(), [report for report in reports if report.failed]
            if not left or not failed or not stall or time.monotonic() > end:
                break
            item.user_properties.append((REPEATED, f"{stall:.2f} s: {_last_line(failed[0])}"))
            _forget_failed_fixtures(item)
        return reports

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        said = dict.fromkeys(_said(terminalreporter))
        if said:
            terminalreporter.section("tried again: the machine stood still")
            for line in said:
                terminalreporter.write_line(line)


def _said(terminal: pytest.TerminalReporter) -> Iterator[str]:
    for reports in terminal.stats.values():
        for report in reports:
            for name, text in getattr(report, "user_properties", ()):
                if name == REPEATED:
                    yield f"{report.nodeid} stood still for {text}"


def _last_line(report: pytest.TestReport) -> str:
    crash = getattr(report.longrepr, "reprcrash", None)
    return str(crash.message).split("\n")[0] if crash else report.longreprtext.strip().split("\n")[-1]


def _forget_failed_fixtures(item: pytest.Item) -> None:
    """A fixture that failed is kept as its error: of a module or session it would fail all later tries, too."""
    for found in item._fixtureinfo.name2fixturedefs.values() if isinstance(item, pytest.Function) else ():
        for fixture in found:
            if fixture.cached_result is not None and fixture.cached_result[2] is not None:
                fixture.cached_result = None
