"""Only what failed while the machine stood still is tried again."""

import pytest

from tests.stalls import STALL_S, TRIES, Stalls, Watch

pytest_plugins = ["pytester"]
TRIED = """
import pytest
tries = []
@pytest.fixture(scope="module")
def made():
    tries.append(1)
    assert len(tries) >= {made}
    return 1
def test_it(made):
    tries.append(1)
    assert len(tries) >= {right}, f"too early: {{len(tries)}}"
"""


class Machine(Watch):
    """One that stands still in each of the first tries."""

    def __init__(self, stalls: int) -> None:
        super().__init__()
        self._left = stalls

    def longest(self) -> float:
        self._left -= 1
        return 2 * STALL_S if self._left >= 0 else 0.0


def outcome(pytester: pytest.Pytester, stalls: int, right: int, made: int = 0) -> tuple[str, str]:
    """How a test ends that is right from its `right`th count on, and what is said."""
    pytester.makepyfile(test_it=TRIED.format(right=right, made=made))
    plugin = Stalls(Machine(stalls))
    done = pytester.inline_run("-p", "no:cacheprovider", "-p", "no:asyncio", plugins=[plugin])
    passed, _, failed = done.listoutcomes()
    reports = [*passed, *failed]
    said = [text for report in reports for name, text in report.user_properties if name == "repeated"]
    assert len({report.nodeid for report in reports}) == 1
    return ("failed" if failed else "passed"), "; ".join(dict.fromkeys(said))


def test_a_failure_on_a_machine_that_ran_counts_at_once(pytester: pytest.Pytester) -> None:
    assert outcome(pytester, stalls=0, right=3) == ("failed", "")


def test_a_failure_while_it_stood_still_is_tried_again_and_said(pytester: pytest.Pytester) -> None:
    ended, said = outcome(pytester, stalls=1, right=3)
    assert ended == "passed" and "0.20 s: AssertionError: too early: 2" in said


def test_so_is_a_fixture_of_the_whole_module(pytester: pytest.Pytester) -> None:
    assert outcome(pytester, stalls=1, right=0, made=2)[0] == "passed"


def test_a_test_that_is_wrong_fails_however_the_machine_is(pytester: pytest.Pytester) -> None:
    ended, said = outcome(pytester, stalls=99, right=99)
    assert ended == "failed" and said.count("too early") == TRIES - 1


def test_a_thread_that_is_kept_from_looking_says_for_how_long(monkeypatch: pytest.MonkeyPatch) -> None:
    times = iter([0.0, 0.02, 0.04, 1.04, 1.06])
    watch = Watch(lambda: next(times))
    looks = iter([False, False, False, False, True])
    monkeypatch.setattr(watch._over, "wait", lambda seconds: next(looks))
    watch._look()
    assert watch.longest() == pytest.approx(1.0)
    watch.begin()
    assert watch.longest() == 0.0
