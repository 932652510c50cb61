"""The reference menu: what each actuator is offered, and the points that the page draws."""

import numpy as np
import pytest

from controller.arrays import Array
from controller.reference import library
from controller.schema.actuator import PRESETS
from controller.schema.parameters import RigParameters
from server.drawing.errors import UnknownReference
from server.drawing.messages import ReferenceInfo
from server.drawing.picture import POINTS
from server.drawing.planned import named
from server.drawing.references import known, listed, path
from tests.server.live_server import TestServer, wait_for


def rig(actuator: str) -> RigParameters:
    return RigParameters(actuator=PRESETS[actuator])


def menu(actuator: str) -> dict[str, ReferenceInfo]:
    return {info.name: info for info in listed(rig(actuator))}


def drawn(name: str, actuator: str = "P1") -> tuple[Array, Array, int]:
    found = path(rig(actuator), name)
    return np.array(found.t), np.array(found.points), found.start


def test_every_reference_of_the_library_and_the_live_path_are_offered() -> None:
    offered = menu("P1")
    assert set(offered) == {*library.names(), "live_path"}
    assert all(info.reachable and not info.reason for info in offered.values())
    assert len({(info.task, info.title) for info in offered.values()}) == len(offered)


def test_the_facts_of_vu_are_the_paper_s() -> None:
    vu = menu("P1")["vu"]
    assert (vu.duration, vu.approach, vu.frequency) == (25.0, 2.0, None)
    assert vu.length == pytest.approx(0.125, abs=1e-6)
    assert vu.peak_speed == pytest.approx(5e-3, rel=1e-3)


def test_steps_jump_so_they_have_no_peak_speed() -> None:
    step = menu("P1")["step"]
    assert step.peak_speed is None
    assert step.duration == 12.0
    t, p, _ = drawn("step")
    apart = np.linalg.norm(np.diff(p, axis=0), axis=1)
    assert np.diff(t)[apart > 10e-3] == pytest.approx([1e-3] * 4), "both sides of every jump are drawn"


@pytest.mark.parametrize("name", ["step", "vu", "digit_8", "circle_1hz", "live_path"])
def test_the_points_are_few_and_lie_on_the_reference(name: str) -> None:
    t, p, start = drawn(name)
    info = menu("P1")[name]
    assert len(t) == len(p) <= POINTS
    assert (np.diff(t) > 0.0).all()
    assert t[start] == pytest.approx(info.approach)
    assert t[-1] == pytest.approx(info.approach + info.duration, abs=2e-3)
    length = np.linalg.norm(np.diff(p[start:], axis=0), axis=1).sum()
    assert length == pytest.approx(info.length, rel=0.02)


def test_what_an_actuator_cannot_reach_says_why_and_is_drawn_without_an_approach() -> None:
    weak = RigParameters(actuator=PRESETS["P1"].model_copy(update={"u_max": 0.03}))
    offered = {info.name: info for info in listed(weak)}
    assert offered["live_path"].reachable, "it is followed live, projected into the reach"
    vu = offered["vu"]
    assert not vu.reachable
    assert "reach" in vu.reason
    assert (vu.length, vu.approach) == (pytest.approx(0.125, abs=1e-6), 0.0)
    assert path(weak, "vu").start == 0


def test_for_p3_the_shapes_are_placed_lower() -> None:
    (_, here, start), (_, there, _) = drawn("digit_0"), drawn("digit_0", "P3")
    assert (there - here)[start:, 1] == pytest.approx(library.SHIFT["P3"], abs=1e-4)


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownReference, match=r"'spiral' is not one of Four steps; Digit 0; .*; Live path"):
        path(rig("P1"), "spiral")


def test_every_reference_has_one_title_that_no_other_has_and_is_known_and_planned_by_it() -> None:
    offered = menu("P1")
    assert len({info.title for info in offered.values()}) == len(offered)
    assert {known(info.title) for info in offered.values()} == set(offered)
    assert path(rig("P1"), "Circle, 0.25 Hz") == path(rig("P1"), "circle_0.25hz")
    for name in ("circle_0.25hz", "Circle, 0.25 Hz"):
        assert named(name, rig("P1")).name == "Circle, 0.25 Hz", "what results, recordings and messages call it"


def test_any_viewer_gets_the_menu_and_the_points(server: TestServer) -> None:
    page = server.page().sign_in()
    wait_for(lambda: page.get("/api/rig").status_code == 200, "the rig")
    offered = page.get("/api/references").json()
    assert [info["name"] for info in offered] == list(menu("P1"))
    vu = page.get("/api/references/vu").json()
    assert len(vu["t"]) == len(vu["points"]) <= POINTS
    unknown = page.get("/api/references/spiral")
    assert unknown.status_code == 404
    assert "Live path" in unknown.json()["detail"]
