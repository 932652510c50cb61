"""What the frame step makes of captured points: the plane, units, and names that are held against geometry."""

from collections.abc import Mapping

import numpy as np
import pytest

from controller.errors import CommandRefused
from controller.schema.actuator import PRESETS
from controller.schema.hardware import Frame
from controller.schema.parameters import RigParameters
from server.hardware.commissioning import frame, planning, points
from server.hardware.commissioning.messages import CaptureBody
from server.hardware.commissioning.named_markers import Rest
from server.hardware.commissioning.planning import Believed

STRAIGHT = Believed(np.column_stack((0.0253 * np.arange(1, 11), np.zeros(10))), (3.4e-6, 1.3e-6))
LABELS = {"three": 3, "six": 6, "nine": 9, "tip": 10}


def camera(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A rotation (3,3) and a place (3,) of the plane in a camera's coordinates."""
    random = np.random.default_rng(seed)
    Q, R = np.linalg.qr(random.normal(size=(3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.sign(np.linalg.det(Q)), random.uniform(-2.0, 2.0, 3)


def bent_by(sag: float) -> Believed:
    """An arm of 253 mm whose tip rests `sag` [m] off x."""
    x = 0.0253 * np.arange(1, 11)
    return Believed(np.column_stack((x, sag * (x / 0.253) ** 2)), STRAIGHT.ways)


def seen(believed: Believed, labels: Mapping[str, int], seed: int = 3) -> Rest:
    """The arm as a camera sees it, with the markers really at the rods of `labels`."""
    Q, place = camera(seed)
    rods = np.column_stack((believed.rods, np.zeros(10))) @ Q.T + place
    return Rest(place, rods[-1], {name: rods[rod - 1] for name, rod in labels.items()})


@pytest.mark.parametrize("sag", [0.0, 0.06])
@pytest.mark.parametrize("seed", range(5))
def test_the_frame_carries_base_and_tip_to_where_they_are_whatever_way_the_camera_looks(seed: int, sag: float) -> None:
    (Q, place), believed = camera(seed), bent_by(sag)
    plane = np.array([(0.0, 0.0, 0.0), (*believed.rods[-1], 0.0), (0.19, 0.13, 0.0), (0.1, -0.05, 0.0)])
    shown = plane @ Q.T + place
    found = frame.judged_frame(seen(believed, LABELS, seed), shown[2], believed, LABELS, Frame())
    assert found.good, found.text
    axes = np.array(found.changes["motion_capture.frame.axes"])
    origin = np.array(found.changes["motion_capture.frame.origin"])
    assert shown @ axes.T + origin == pytest.approx(plane[:, :2], abs=1e-9)
    assert axes @ axes.T == pytest.approx(np.eye(2), abs=1e-12)
    Frame.model_validate({"axes": axes.tolist(), "origin": origin.tolist()})
    assert len(found.text) < 200, "the rig file keeps no more"


def test_a_frame_in_other_units_or_of_a_straight_pose_is_refused_with_numbers() -> None:
    def judged(tip: float) -> str:
        found = frame.judged_rest(Rest(np.zeros(3), np.array([0.0, tip, 0.0]), {}), STRAIGHT, {})
        assert not found.good
        return found.text

    assert "253 m apart, and the actuator's are 0.253 m" in judged(253.0)
    assert "does the camera measure in mm?" in judged(253.0)
    assert "does the camera measure in inches?" in judged(10.0)
    assert "is its driver's unit 1000 times too small?" in judged(0.000253)
    assert "are the units right, and was it the tip?" in judged(0.291)
    assert judged(0.0) == "base and tip at rest are one and the same point"
    straight = Rest(np.zeros(3), np.array([0.0, 0.253, 0.0]), {})
    found = frame.judged_frame(straight, np.array([0.004, 0.2, 0.0]), STRAIGHT, {}, Frame())
    assert not found.good and "the bent pose is 0.004 m off the line from base to tip: at least 0.005 m" in found.text


@pytest.mark.parametrize("sag", [0.0, 0.06])
@pytest.mark.parametrize(
    "labels, complaint",
    [
        ({"six": 10, "tip": 6}, "labels six and tip are swapped: six lies at rod 6, tip lies at rod 10"),
        ({"three": 6, "six": 3}, "labels three and six are swapped: three lies at rod 3, six lies at rod 6"),
        ({"nine": 10, "tip": 9}, "labels nine and tip are swapped: nine lies at rod 9, tip lies at rod 10"),
        ({"six": 7}, "six lies at rod 6, and labels say rod 7"),
        ({"three": 6, "six": 9, "nine": 3}, "three lies at rod 3, and labels say rod 6; six lies at rod 6, and"),
        ({"four": 4}, "four (rod 4) was not seen at rest"),
    ],
)
def test_a_marker_that_lies_at_another_rod_than_its_name_says_is_named(
    labels: dict[str, int], complaint: str, sag: float
) -> None:
    believed = bent_by(sag)
    rest = seen(believed, LABELS)
    found = frame.judged_rest(rest, believed, LABELS | labels)
    assert not found.good and complaint in found.text
    by_name = rest._replace(tip=rest.named[next(name for name, rod in (LABELS | labels).items() if rod == 10)])
    misled = frame.judged_rest(by_name, believed, LABELS | labels)
    assert not misled.good and ("swapped" not in complaint or complaint in misled.text), "by whichever name it is taken"


def test_a_marker_far_from_every_rod_is_named_and_one_glued_a_little_off_is_not() -> None:
    rest = seen(STRAIGHT, LABELS)
    height = np.linalg.svd((rest.tip - rest.base)[None])[2][1]
    glued = rest._replace(named=rest.named | {"six": rest.named["six"] + 0.02 * height})
    assert frame.judged_rest(glued, STRAIGHT, LABELS).good
    far = rest._replace(named=rest.named | {"six": rest.named["six"] + 0.04 * height})
    found = frame.judged_rest(far, STRAIGHT, LABELS)
    assert not found.good and "six lies 40 mm from rod 6, which labels say" in found.text
    assert [one.name for one in found.numbers if not one.kept] == ["six, from rod 6"]


@pytest.mark.parametrize("longer", [0.92, 1.0, 1.08])
def test_an_arm_a_little_longer_than_believed_keeps_its_names(longer: float) -> None:
    believed = Believed(longer * STRAIGHT.rods, STRAIGHT.ways)
    assert frame.judged_rest(seen(believed, LABELS), STRAIGHT, LABELS).good


@pytest.mark.parametrize(
    "x, y, words",
    [
        ((1, 0, 0), (0, 1, 0), ""),
        ((1, 0, 0.2), (0, 1, 0), ""),
        ((1, 0, 0), (0, -1, 0), "; y of the rig file was mirrored"),
        ((-1, 0, 0), (0, 1, 0), "; x of the rig file was mirrored"),
        ((-1, 0, 0), (0, -1, 0), "; the rig file had the camera upside down"),
        ((0, 1, 0), (1, 0, 0), "; x of the rig file was 90 degrees off, y 90"),
    ],
)
def test_what_was_wrong_with_the_rig_files_own_frame_is_said(
    x: tuple[float, ...], y: tuple[float, ...], words: str
) -> None:
    assert frame.turned(Frame.model_validate({"axes": [x, y]}), np.eye(3)[:2]) == words


def test_a_point_that_moves_or_is_hardly_seen_is_not_captured() -> None:
    still = [np.array([1.0, 2.0, 3.0])] * 9 + [np.array([1.0, 2.0, 3.001])]
    steady = points.median("base", "wand", still)
    points.require_still(steady)
    assert steady.at == [1.0, 2.0, 3.0]
    with pytest.raises(CommandRefused, match="tip: the point was seen 4 times"):
        points.median("tip", "wand", still[:4])
    moving = points.median("tip", "wand", [np.array([0.01 * n, 0.0, 0.0]) for n in range(10)])
    with pytest.raises(CommandRefused, match=r"tip: the point moved by 0\.0\d+ m \(rms\), at most 0.002 m"):
        points.require_still(moving)


def test_a_point_without_a_name_is_followed_where_its_number_changes() -> None:
    looks = [{"#1": np.array([0.1 * n, 0.0, 0.0]), "#2": np.array([5.0, 0.0, 0.0])} for n in range(5)]
    looks += [{"#2": np.array([0.1 * n, 0.0, 0.0]), "#1": np.array([5.0, 0.0, 0.0])} for n in range(5, 10)]
    found = points.captured(CaptureBody(place="tip", point="#1"), looks)
    assert found.at[0] == pytest.approx(0.45)


@pytest.mark.parametrize("actuator", PRESETS.values(), ids=PRESETS)
def test_the_models_rest_is_that_of_its_static_map(actuator: object) -> None:
    rig = RigParameters(actuator=actuator)  # type: ignore[arg-type]
    believed = planning.believed(rig)
    assert believed.rods[-1] == pytest.approx((rig.actuator.length, 0.0), abs=1e-9)
    assert np.linalg.norm(np.diff(believed.rods, axis=0), axis=1) == pytest.approx(rig.actuator.length / 10)
    assert believed.ways[0] > 1.5 * believed.ways[1] > 0.0
