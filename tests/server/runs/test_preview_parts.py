"""A preview that is told as it comes, part by part."""

import asyncio
import json
import os
import re
import signal
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest

from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters, Settings
from server.drawing.errors import UnknownReference
from server.runs import planning, previews
from server.runs.messages import Preview, PreviewBody, PreviewPart
from server.runs.preview import PreviewInParts, predicted
from server.runs.previews import Previews
from tests.server.live_server import PLANNER, TestServer

pytestmark = [pytest.mark.process, pytest.mark.keyed()]

RIG, LIVE, REST = RigParameters(), Settings(), np.zeros(2)
LONG = PreviewBody(reference="circle_0.25hz", laps=25)
"""100 s and an approach: for several parts."""


def joined(parts: list[PreviewPart]) -> dict[str, list[Any]]:
    """What a page has in the end."""
    whole: dict[str, list[Any]] = {"t": [], "points": [], "saturated": []}
    for part in parts:
        for name, rows in whole.items():
            rows[part.first :] = getattr(part, name)
    return whole


def assert_joined(parts: list[PreviewPart], expected: Preview) -> None:
    last = parts[-1]
    assert last.preview is not None
    assert last.preview.model_copy(update={"seconds": 0.0}) == expected.model_copy(update={"seconds": 0.0})
    assert joined(parts) == {name: getattr(expected, name) for name in ("t", "points", "saturated")}
    assert {part.start for part in parts} == {expected.start}
    assert (last.progress, last.problem) == (1.0, "")


def as_given(rig: RigParameters) -> RigParameters:
    """Stands for the rig in what is foreseen: it is no rig of devices that was measured."""
    return rig


@pytest.mark.parametrize("seconds", [0.0, 0.02])
def test_the_parts_are_the_preview(seconds: float) -> None:
    body = PreviewBody(reference="vu", laps=2)
    found = PreviewInParts(body, RIG, LIVE, REST)
    parts = [found.part()]
    while parts[-1].preview is None:
        found.go_on(seconds)
        parts.append(found.part())
    assert len(parts) > 3
    assert [part.progress for part in parts] == sorted(part.progress for part in parts)
    assert_joined(parts, predicted(body, RIG, LIVE, REST))


@pytest.mark.parametrize("dt", [5e-4, 2e-3])
def test_a_rig_of_another_period_has_the_preview_of_any_other(dt: float) -> None:
    """It was refused: every reference was taken to be sampled each millisecond."""
    rig = RIG.model_copy(update={"controller": RIG.controller.model_copy(update={"dt": dt})})
    for u in (REST, np.array([0.02, -0.01])):
        body = PreviewBody(reference="circle_1hz", laps=2)
        usual, found = predicted(body, RIG, LIVE, u), predicted(body, rig, LIVE, u)
        assert found.broken_off == "" and found.t[-1] == pytest.approx(usual.t[-1], abs=0.01)
        for name in ("rmse", "max_error"):
            assert getattr(found, name) == pytest.approx(getattr(usual, name), rel=0.15), name
        for name in ("lag_deg_x", "lag_deg_y"):
            assert getattr(found, name) == pytest.approx(getattr(usual, name), abs=2.0), name
    wild = LIVE.model_copy(update={"K_P": (5.0, 5.0), "K_I": (20.0, 20.0)})
    stops = [predicted(PreviewBody(reference="circle_1hz", laps=3), one, wild, REST).broken_off for one in (RIG, rig)]
    times = [float(re.search(r"after (\d+\.\d+) s", stop)[1]) for stop in stops]  # type: ignore[index]
    assert times[0] == pytest.approx(times[1], abs=0.5)


def test_the_parts_end_where_the_run_would_be_broken_off() -> None:
    wild = LIVE.model_copy(update={"K_P": (5.0, 5.0), "K_I": (20.0, 20.0)})
    body = PreviewBody(reference="circle_1hz", laps=3)
    found = PreviewInParts(body, RIG, wild, REST)
    parts = [found.part()]
    while parts[-1].preview is None:
        found.go_on(0.0)
        parts.append(found.part())
    expected = predicted(body, RIG, wild, REST)
    assert expected.broken_off != ""
    assert parts[-1].progress < 1.0
    assert parts[-1].preview is not None and parts[-1].preview.points == expected.points
    assert parts[-1].preview.broken_off == expected.broken_off
    assert joined(parts)["t"][-1] == pytest.approx(expected.t[-1], abs=0.1)


class Watched:
    """The planner, which notes the names of what is begun."""

    def __init__(self, most: int = 10) -> None:
        self.keys: list[str] = []
        self.most = most

    async def do(self, work: Callable[..., Any], *arguments: Any) -> Any:
        if work is planning.begin_preview:
            self.keys.append(arguments[0])
            assert len(self.keys) <= self.most, "begun again and again"
        return await PLANNER.do(work, *arguments)

    def call(self, work: Callable[..., Any], *arguments: Any) -> Any:
        return PLANNER.call(work, *arguments)


def told(after_first: Callable[[], object]) -> tuple[list[PreviewPart], Watched]:
    """All parts of LONG, where `after_first` happens between the first and the second."""
    planner = Watched()

    async def gather() -> list[PreviewPart]:
        coming = Previews(cast(Any, planner), cast(Any, as_given)).parts(LONG, RIG, LIVE, REST)
        found = [await anext(coming)]
        after_first()
        return found + [part async for part in coming]

    return asyncio.run(gather()), planner


def begin_others() -> None:
    for number in range(planning.KEPT):
        asked = planning.Asked(PreviewBody(reference="vu"), RIG, LIVE, REST, planning.NOTHING)
        PLANNER.call(planning.begin_preview, f"other {number}", asked)


def kill() -> None:
    os.kill(cast(int, PLANNER.pid), signal.SIGKILL)


@pytest.mark.parametrize("accident", [kill, begin_others])
def test_a_preview_that_the_planner_knows_no_more_is_begun_again(accident: Callable[[], None]) -> None:
    found, planner = told(accident)
    assert len(planner.keys) == 2
    assert [part.first for part in found].count(0) == 2
    assert_joined(found, predicted(LONG, RIG, LIVE, REST))


def test_more_than_the_planner_keeps_come_to_their_end() -> None:
    count = planning.KEPT + 1
    planner = Watched(count)

    async def gather() -> list[list[PreviewPart]]:
        all_of_them = Previews(cast(Any, planner), cast(Any, as_given))
        return await asyncio.gather(*(whole(all_of_them) for _ in range(count)))

    for found in asyncio.run(gather()):
        assert len(found) > 1 and found[-1].preview is not None


async def whole(all_of_them: Previews) -> list[PreviewPart]:
    return [part async for part in all_of_them.parts(LONG, RIG, LIVE, REST)]


def test_who_does_not_take_the_next_part_makes_room_and_gets_the_rest_when_they_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(previews, "IDLE", 0.05)
    planner = Watched(planning.KEPT + 2)

    async def gather() -> list[PreviewPart]:
        all_of_them = Previews(cast(Any, planner), cast(Any, as_given))
        idle = [all_of_them.parts(LONG, RIG, LIVE, REST) for _ in range(planning.KEPT)]
        for one in idle:
            await anext(one)
        assert (await asyncio.wait_for(whole(all_of_them), 60.0))[-1].preview is not None
        found = [part async for part in idle[0]]
        for one in idle:
            await one.aclose()
        return found

    assert asyncio.run(gather())[-1].preview is not None


def test_who_goes_away_leaves_nothing_in_the_planner() -> None:
    planner = Watched()

    async def look_once() -> None:
        coming = Previews(cast(Any, planner), cast(Any, as_given)).parts(LONG, RIG, LIVE, REST)
        await anext(coming)
        await coming.aclose()

    asyncio.run(look_once())
    (key,) = planner.keys
    assert PLANNER.call(planning.go_on_with_preview, key) is None


def test_what_cannot_be_run_at_all_is_refused_before_the_first_part() -> None:
    with pytest.raises(UnknownReference):
        coming = Previews(PLANNER, cast(Any, as_given)).parts(
            PreviewBody(reference="nonsense"), cast(Any, RIG), LIVE, REST
        )
        asyncio.run(anext(coming))  # type: ignore[arg-type]


def test_a_page_is_told_the_parts_as_they_come(server: TestServer) -> None:
    page = server.operator()
    with page.live() as live:  # the rig may still stand where the test before left it
        live.wait_mode(Mode.VENTED)
    answer = page.post("/api/preview/parts", json=LONG.model_dump(mode="json"))
    assert (answer.status_code, answer.headers["content-type"]) == (200, "application/x-ndjson")
    parts = [PreviewPart.model_validate(json.loads(line)) for line in answer.text.splitlines()]
    assert len(parts) > 1
    rig, settings = server.services.rig.require_info().parameters, server.services.operator.settings
    assert_joined(parts, predicted(LONG, rig, settings, REST))
    assert page.post("/api/preview/parts", json={"reference": "nonsense"}).status_code == 404
    assert page.post("/api/preview/parts", json={}).status_code == 422
