"""The calibration's data and formulas: unknowns, residuals, the file. No exact figure of the twin is expected."""

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import ParameterError, TendrilError
from controller.research.calibration.fit_file import FitOrigin, Result, fit_text, toml
from controller.research.calibration.margins import GAIN_FACTOR, Margin, Trial
from controller.research.calibration.predictions import BROKEN, row_residual
from controller.research.calibration.problem import Evaluation, Problem
from controller.research.calibration.space import Space, place, space_of, value_in
from controller.research.calibration.spread import row_spread
from controller.research.calibration.unknowns import UNKNOWNS, Unknown
from controller.research.experiments.paper_rows import FITTED, JUDGED
from controller.schema.fit import FIT, GAIN_NAMES
from controller.schema.parameters import ROD_ONLY, CosseratParameters, Settings, TwinParameters
from controller.simulation.case import Setup
from server.cli.main import app

pytestmark = [pytest.mark.keyed("server/cli/research/commands.py")]

SPACE = Space()
RMSE, SSE = FITTED[0], FITTED[4]


def test_a_share_of_the_box_comes_back_from_its_value() -> None:
    for share in (0.0, 0.3, 1.0):
        assert [one.share(one.value(share)) for one in UNKNOWNS] == pytest.approx([share] * len(UNKNOWNS))


def test_what_is_decoded_has_four_digits_and_the_rest_is_the_base() -> None:
    base = Setup(TwinParameters(marker_noise=3e-4))
    setup = Space(base=base).decode(np.full(len(UNKNOWNS), 1 / 3))
    assert setup.twin.marker_noise == 3e-4
    numbers = [value_in(setup, one.name) for one in UNKNOWNS]
    assert numbers == [float(f"{number:.4g}") for number in numbers]
    assert numbers == pytest.approx([one.value(1 / 3) for one in UNKNOWNS], rel=1e-3)
    assert setup.gains.K_P[0] == setup.gains.K_P[1]


def test_both_ends_of_every_unknown_are_allowed_by_the_parameters_even_with_more_gain() -> None:
    for end in (0.0, 1.0):
        setup = SPACE.decode(np.full(len(UNKNOWNS), end))
        for one in UNKNOWNS:
            assert value_in(setup, one.name) == pytest.approx(one.value(end), rel=1e-3)
        Settings(**{name: tuple(GAIN_FACTOR * gain for gain in getattr(setup.gains, name)) for name in GAIN_NAMES})


def test_every_prior_lies_inside_its_bounds_and_surprises_nobody() -> None:
    assert len({one.name for one in UNKNOWNS}) == len(UNKNOWNS)
    assert all(one.low < one.prior < one.high and one.spread > 0.0 for one in UNKNOWNS)
    assert SPACE.prior_residuals(SPACE.prior_point()) == pytest.approx(0.0, abs=2e-3)


def test_a_surprise_counts_spreads_on_the_scale_of_the_unknown() -> None:
    plain, log = Unknown("zeta", 0.1, 0.9, 0.4, 0.1), Unknown("zeta", 0.1, 0.9, 0.4, 0.5, log=True)
    assert plain.surprise(0.6) == pytest.approx(2.0)
    assert log.surprise(0.4 * math.exp(0.5)) == pytest.approx(1.0)
    assert log.value(0.5) == pytest.approx(0.3)


@pytest.mark.parametrize("z", [np.full(len(UNKNOWNS), 1.01), np.full(len(UNKNOWNS), np.nan), np.zeros(3)])
def test_a_point_outside_the_box_is_refused(z: np.ndarray) -> None:
    with pytest.raises(ParameterError, match=r"numbers in \[0, 1\]"):
        SPACE.decode(z)


@pytest.mark.parametrize("name", ["mood", "creep.2", "mood.0"])
def test_an_unknown_that_nothing_has_is_refused(name: str) -> None:
    fields: dict[str, Any] = TwinParameters().model_dump()
    with pytest.raises(ParameterError, match="no field of the twin"):
        place(fields, name, 1.0)


def test_screened_points_are_spread_as_the_priors_are() -> None:
    points = SPACE.draw(257, seed=1)
    assert (points[0] == SPACE.prior_point()).all() and ((points >= 0.0) & (points <= 1.0)).all()
    assert (points == SPACE.draw(257, seed=1)).all() and (points != SPACE.draw(257, seed=2)).any()
    off = [SPACE.unknowns[j].surprise(SPACE.unknowns[j].value(z[j])) for z in points for j in range(len(z))]
    assert np.abs(np.mean(off)) < 0.15 and 0.6 < np.std(off) <= 1.0


def test_the_paper_number_leaves_nothing_and_a_tenth_more_costs_one_deviation() -> None:
    assert RMSE.paper is not None and SSE.paper is not None
    assert row_residual(RMSE, (RMSE.paper, 1.0)) == 0.0
    assert row_residual(RMSE, (1.1 * RMSE.paper, 1.0)) == pytest.approx(1.0, rel=0.05)
    assert row_residual(RMSE, (RMSE.paper / 1.1, 1.0)) == pytest.approx(-1.0, rel=0.05)
    assert abs(row_residual(SSE, (1.1 * SSE.paper, 1.0))) < 0.5


def test_a_broken_run_costs_less_the_longer_it_lasts_and_more_than_any_whole_one() -> None:
    late, early = row_residual(RMSE, (math.nan, 0.9)), row_residual(RMSE, (math.nan, 0.1))
    assert BROKEN < late < early < 3.0 * BROKEN
    assert abs(row_residual(RMSE, (300.0, 1.0))) < BROKEN


def result() -> Result:
    z = np.random.default_rng(3).uniform(size=len(UNKNOWNS))
    margin = Margin(Trial("P1", "stop", "gain"), 1e-3, 0.5, 1.0)
    best = Evaluation(z, tuple((row.paper or 0.0, 1.0) for row in FITTED), (margin,), np.ones(4))
    spread = tuple(row_spread(row, np.array([2.0, 1.0, np.nan, 4.0]), 0.0) for row in JUDGED)
    origin = FitOrigin("2026-01-02", 'tendril calibrate --out "my fit.toml"', "0.1", 1.0, 1, 2, "finished")
    return Result(Problem(), best, (best,), spread, origin)


def test_the_file_gives_back_the_fit_bit_by_bit_and_can_take_the_place_of_the_default() -> None:
    found = result()
    text, setup = fit_text(found), SPACE.decode(found.best.z)
    read = tomllib.loads(text)
    assert TwinParameters(**read["twin"]) == setup.twin
    assert {name: (read["gains"][name],) * 2 for name in GAIN_NAMES} == {
        name: getattr(setup.gains, name) for name in GAIN_NAMES
    }
    assert all(read[table].keys() >= FIT[table].keys() for table in ("fit", "twin", "gains"))
    assert read["fit"]["cost"] == read["fit"]["cost_most"] == 2.0 and read["fit"]["command"] == found.origin.command
    assert [row["ratio"] for row in read["rows"]] == [1.0] * len(FITTED)
    assert {name: read["spread"][0][name] for name in ("best", "low", "median", "high", "numbers")} == {
        "best": 2.0, "low": 1.0, "median": 2.0, "high": 4.0, "numbers": 3
    }  # fmt: skip
    assert read["discrepancy"] == {"size": 0.0, "fit_rows_inside": 0, "fit_rows": 0}  # none of the spread's is one
    assert [(one["role"], one["inside"]) for one in read["spread"]] == [
        ("held-out", True),
        ("held-out", True),
        ("held-out", False),
    ]
    names, [values] = read["ensemble"]["names"], read["ensemble"]["values"]
    assert dict(zip(names, values, strict=True)) == SPACE.values(found.best.z)


def test_a_row_that_no_fit_lasts_has_no_number() -> None:
    spread = row_spread(JUDGED[0], np.full(3, np.nan), 1.0)
    assert spread.numbers == 0 and math.isnan(spread.median)


@pytest.mark.parametrize(
    ("out", "complaint"),
    [
        ("fit.json", "does not end in .toml"),
        ("nowhere/fit.toml", "its folder does not exist"),
        ("folder.toml", "it is a folder"),
    ],
)
def test_a_file_that_cannot_be_written_is_named_before_the_search(tmp_path: Path, out: str, complaint: str) -> None:
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(TendrilError, match=complaint):
        app(["calibrate", "--out", str(tmp_path / out)], standalone_mode=False)


@pytest.mark.parametrize("text", ['--out "my fit.toml"', "a\\b\t\n\r\x00\x1b\x7f", "fit-\u00e9-\U0001f980.toml"])
def test_any_command_is_read_back_from_the_file(text: str) -> None:
    found = result()
    written = fit_text(replace(found, origin=replace(found.origin, command=text)))
    assert tomllib.loads(written)["fit"]["command"] == text


def test_a_bool_is_one_in_the_file_too_and_what_is_no_text_does_no_harm() -> None:
    read = tomllib.loads(f"yes = {toml(True)}\nsome = {toml((1, 2.5))}\nbytes = {toml(chr(0xDCFF))}")
    assert read == {"yes": True, "some": [1, 2.5], "bytes": "?"}


def test_the_cosserat_plant_has_unknowns_of_its_own_and_its_file_gives_back_its_fit() -> None:
    space = space_of("cosserat")
    base = space.base.twin
    assert (base.plant, base.cosserat) == ("cosserat", CosseratParameters())
    assert {one.name.partition(".")[0] for one in space.unknowns}.isdisjoint(ROD_ONLY)
    z = np.random.default_rng(4).uniform(size=len(space.unknowns))
    found = result()
    found = replace(found, problem=Problem(space), best=replace(found.best, z=z), fits=(replace(found.best, z=z),))
    read = TwinParameters(**tomllib.loads(fit_text(found))["twin"])
    assert read == space.decode(z).twin.model_copy(update={"integrator": read.integrator})
