"""`tendril identify` and `tendril observe` on the free decays of a real trunk (tests/data/trunk-stack, MIT licence)."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import TendrilError
from controller.research.identification.motion.decays import Decay, read_decays
from controller.research.identification.observe import ObserverTask, observe_decays
from controller.schema.actuator import read_actuator
from controller.schema.origin import Origin
from server.cli.main import app
from server.cli.research.observed import write_observed
from tests.controller.decaying import decays_of, hanging_body
from tests.docs.blocks import EXAMPLES

pytestmark = pytest.mark.keyed("server/cli/research/commands.py", "tests/data", "docs/examples")

TRUNK = Path(__file__).parents[2] / "data" / "trunk-stack" / "decay_200g_even_ids.csv"


def run(*arguments: object) -> None:
    app([str(one) for one in arguments], standalone_mode=False)


@pytest.fixture(scope="module")
def trunk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("trunk") / "trunk.toml"
    run("identify", TRUNK, "--ids", "0-16", "--out", out)
    return out


def scores(trunk: Path, folder: Path, *options: object) -> dict[tuple[int, float], dict[str, Any]]:
    run("observe", TRUNK, "--actuator", trunk, "--ids", "18-34", *options, "--json", folder / "scores.json")
    found = json.loads((folder / "scores.json").read_text())
    made = Origin.model_validate(found["origin"])
    assert list(made.files) == [TRUNK.name] and len(made.actuators) == 1
    return {(one["body"], one["from_s"]): one for one in found["bodies"]}


def test_the_observer_given_the_tip_of_a_real_trunk_beats_what_needs_no_model(trunk: Path, tmp_path: Path) -> None:
    found = scores(trunk, tmp_path, "--sense", 3, "--score", "1,2", "--from", 0.3)
    assert set(found) == {(1, 0.0), (1, 0.3), (2, 0.0), (2, 0.3)}
    for one in found.values():
        assert one["percent_of_motion"] < min(one["constant_curvature_percent"], one["fixed_ratio_percent"])
    assert found[1, 0.3]["percent_of_motion"] <= 33.0
    assert found[2, 0.3]["percent_of_motion"] <= 14.6
    assert found[2, 0.0]["percent_of_motion"] <= 42.0


def test_after_the_release_the_observer_is_as_good_as_the_shape_of_its_first_mode(trunk: Path, tmp_path: Path) -> None:
    found = scores(trunk, tmp_path, "--sense", 3, "--score", "1,2", "--from", 0.3)
    for body in (1, 2):
        late, whole = found[body, 0.3], found[body, 0.0]
        assert late["percent_of_motion"] == pytest.approx(late["mode_shape_percent"], abs=1.0)
        assert whole["percent_of_motion"] < whole["mode_shape_percent"] - 3.0
        assert late["own_ratio_percent"] <= min(late["mode_shape_percent"], late["fixed_ratio_percent"])


def test_the_known_baselines_of_these_decays_come_out(trunk: Path, tmp_path: Path) -> None:
    found = scores(trunk, tmp_path, "--sense", 3, "--score", "2", "--from", 0.3)
    late, whole = found[2, 0.3], found[2, 0.0]
    assert late["constant_curvature_percent"] == pytest.approx(14.8, abs=0.1)
    assert late["fixed_ratio_percent"] == pytest.approx(15.3, abs=0.1)
    assert whole["constant_curvature_percent"] == pytest.approx(55.5, abs=0.5)
    assert whole["fixed_ratio_percent"] == pytest.approx(52.5, abs=0.5)
    assert json.loads((tmp_path / "scores.json").read_text())["samples"] == 1807


def test_several_bodies_may_be_sensed(trunk: Path, tmp_path: Path) -> None:
    one = scores(trunk, tmp_path, "--sense", "3", "--score", "1")
    two = scores(trunk, tmp_path, "--sense", "2,3", "--score", "1")
    assert json.loads((tmp_path / "scores.json").read_text())["sensed"] == [2, 3]
    assert all(two[key]["percent_of_motion"] < one[key]["percent_of_motion"] for key in one)


def test_decays_are_left_out_one_by_one(tmp_path: Path) -> None:
    few = tmp_path / "few.csv"
    rows = [line for line in TRUNK.read_text().splitlines() if line.split(",")[0] in ("ID", "2", "6", "8")]
    few.write_text("\n".join(rows) + "\n")
    run("validate", few, "--sense", 3, "--score", "1,2", "--json", tmp_path / "loo.json")
    found = json.loads((tmp_path / "loo.json").read_text())
    left_out, pooled = [2, 6, 8], {(one["body"], one["from_s"]): one for one in found["forms"][0]["bodies"]}
    assert found["decays"] == left_out
    errors = motions = 0.0
    for one in left_out:
        others = ",".join(str(other) for other in left_out if other != one)
        run("identify", few, "--ids", others, "--out", tmp_path / "others.toml")
        seen = observe_decays(ObserverTask(few, read_actuator(tmp_path / "others.toml"), (3,), (2,), str(one)))
        late = next(body for body in seen.scores["bodies"] if body["from_s"] == 0.3)
        samples = np.count_nonzero(seen.motions[0].t >= 0.3 - 1e-6)
        errors += samples * late["rms_error_mm"] ** 2
        motions += samples * late["rms_motion_mm"] ** 2
    assert pooled[2, 0.3]["percent_of_motion"] == pytest.approx(100 * (errors / motions) ** 0.5, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--ids", "0,2", "--sense", "3", "--score", "1"], "2 decays: leaving one out needs at least 3"),
        (["--sense", "3", "--score", "4"], "body 4 is outside 1 to 3"),
        (["--sense", "3", "--score", "3"], "score = 3 is sensed, too"),
        (["--sense", "3", "--score", "1", "--rate", "0"], r"rate = 0.0 rad/s is outside \[1, 2000\]"),
    ],
)
def test_what_cannot_be_left_out_is_said(options: list[str], complaint: str) -> None:
    with pytest.raises(TendrilError, match=complaint):
        run("validate", TRUNK, *options)


def test_no_sample_of_an_unsensed_body_reaches_the_estimate(trunk: Path, tmp_path: Path) -> None:
    lines = TRUNK.read_text().splitlines()
    header, rows = lines[0], [line.split(",") for line in lines[1:] if line.split(",")[0] == "18"]
    random = np.random.default_rng(0)
    shaken = [[*row[:1], *(f"{float(v) + random.normal(0, 0.01):.6f}" for v in row[1:7]), *row[7:]] for row in rows]
    estimates = []
    for name, content in (("true", rows), ("shaken", shaken)):
        file = tmp_path / f"{name}.csv"
        file.write_text("\n".join([header, *(",".join(row) for row in content)]) + "\n")
        estimates.append(observe_decays(ObserverTask(file, read_actuator(trunk), (3,), (1, 2))).estimates[0])
    assert np.array_equal(*estimates)


def written(decays: list[Decay], file: Path) -> Path:
    bodies = decays[0].points.shape[1]
    rows = ["ID,t," + ",".join(f"{axis}{i + 1}" for i in range(bodies) for axis in "xyz")]
    for one in decays:
        for t, points in zip(one.t, one.points, strict=True):
            rows.append(",".join([str(one.id), f"{t:.4f}", *(f"{value:.6f}" for value in points.ravel())]))
    file.write_text("\n".join(rows) + "\n")
    return file


def test_files_with_other_bodies_and_decays_are_identified_and_observed(tmp_path: Path) -> None:
    arcs = (0.08, 0.15, 0.22, 0.30)
    torques = np.array([[0, 0, 0, 0.4], [0, 0.3, 0, 0.1], [0.3, 0, 0, 0], [0, 0, 0.3, -0.1], [0, 0.2, 0, 0.3]])
    data = written(decays_of(hanging_body(arcs), torques, samples=200), tmp_path / "four.csv")
    run("identify", data, "--ids", "0-4", "--out", tmp_path / "four.toml")
    options = ["--ids", "6,8", "--sense", "4", "--score", "1,2,3", "--from", "0.5", "--json", tmp_path / "f.json"]
    run("observe", data, "--actuator", tmp_path / "four.toml", *options)
    late = [one for one in json.loads((tmp_path / "f.json").read_text())["bodies"] if one["from_s"] == 0.5]
    assert all(one["rms_error_mm"] < 0.5 for one in late)


def test_samples_that_come_faster_than_ticks_are_observed_as_well_as_slow_ones(trunk: Path, tmp_path: Path) -> None:
    slow = [one for one in read_decays(TRUNK, "18") if len(one.t) > 150]
    errors = []
    for step in (1e-2, 4e-4):
        t = np.arange(0.0, slow[0].t[-1] - 0.01, step)
        held = np.searchsorted(slow[0].t, t + 1e-9, "right") - 1
        file = written([Decay(18, t, slow[0].points[held])], tmp_path / "rate.csv")
        observed = observe_decays(ObserverTask(file, read_actuator(trunk), (3,), (2,)))
        errors.append(observed.scores["bodies"][0]["percent_of_motion"])
    assert errors[1] == pytest.approx(errors[0], rel=0.3)


def test_a_body_that_does_not_move_is_not_scored(trunk: Path, tmp_path: Path) -> None:
    decay = read_decays(TRUNK, "18")[0]
    decay.points[:, 0] = decay.points[0, 0]
    file = written([decay], tmp_path / "still.csv")
    with pytest.raises(TendrilError, match=r"score = 1: this body moves less than 1e-09 m from 0.0 s on"):
        observe_decays(ObserverTask(file, read_actuator(trunk), (3,), (1,)))


def test_a_recording_holds_measured_and_estimated_motion_of_every_body(trunk: Path, tmp_path: Path) -> None:
    observed = observe_decays(ObserverTask(TRUNK, read_actuator(trunk), (3,), (2,), "18-20"))
    write_observed(observed, tmp_path / "run.rrd")
    assert (tmp_path / "run.rrd").read_bytes()[:3] == b"RRF"
    with pytest.raises(TendrilError, match="cannot be written"):
        write_observed(observed, Path("/nowhere/run.rrd"))


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--sense", "3", "--score", "3"], "score = 3 is sensed, too"),
        (["--sense", "4", "--score", "1"], "sense = 4 is outside 1 to 3"),
        (["--sense", "3", "--score", "0"], "score = 0 is outside 1 to 3"),
        (["--sense", "", "--score", "1"], "sense = '' is not a list of whole numbers"),
        (["--sense", "3", "--score", "1", "--ids", "19"], "ID 19 is not there"),
        (
            ["--sense", "3", "--score", "1", "--ids", "10"],
            r"no decay to observe has more than 150 samples \(ID 10: 31\)",
        ),
        (["--sense", "3", "--score", "1", "--from", "9"], "from = 9.0 s is after the end of every decay"),
        (["--sense", "3", "--score", "1", "--from", "-1"], "from = -1.0 s is negative"),
        (["--sense", "3", "--score", "1", "--actuator", "P1"], "actuator P1 has no table tracking"),
    ],
)
def test_a_wrong_request_is_said_in_one_line(trunk: Path, options: list[str], complaint: str) -> None:
    actuator = [] if "--actuator" in options else ["--actuator", str(trunk)]
    with pytest.raises(TendrilError, match=complaint) as caught:
        run("observe", TRUNK, *actuator, *options)
    assert "\n" not in str(caught.value)


def test_an_arm_of_a_static_test_alone_is_observed_without_the_ratios_of_decays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arm, table = tmp_path / "arm.toml", tmp_path / "scores.json"
    run("identify", EXAMPLES / "my_poses.csv", "--actuator", EXAMPLES / "base.toml", "--out", arm)
    run("observe", EXAMPLES / "my_decays.csv", "--actuator", arm, "--sense", 4, "--score", "3", "--json", table)
    assert re.search(r"^ +3 .* - ", capsys.readouterr().out, re.MULTILINE)
    late = json.loads(table.read_text())["bodies"][-1]
    assert late["fixed_ratio_percent"] is None and late["percent_of_motion"] < late["constant_curvature_percent"]
