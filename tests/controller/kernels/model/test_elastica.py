"""The chain beside the exact elastica of scipy: same and opposed torques, without and with weight and a tip load."""

import itertools

import numpy as np
import pytest

from controller.assembly.rod import build_rod
from controller.schema.actuator import Actuator, by_joints
from controller.schema.rigidity import joint_stiffness
from tests.controller.chains import static
from tests.controller.elastica import elastica
from tests.controller.statically import static_tip

pytestmark = pytest.mark.keyed()

LENGTH = 0.253
BODY = {"name": "even", "mass": 0.02, "length": LENGTH, "EI": (2.5e-3,), "beta": 1e-3}
LOADS = {
    "none": {},
    "hanging": {"gravity": (9.81, 0.0), "tip_load": 0.02},
    "aside": {"gravity": (0.0, -1.0), "tip_load": 0.005},
}
TORQUES = ((0.03, 0.03), (0.03, -0.03), (-0.045, 0.045), (0.02, 0.0))


def off(actuator: Actuator, rods: int, u: tuple[float, float]) -> float:
    """How far the chain's tip is from the exact one [mm]."""
    exact = elastica(actuator, u, (LENGTH,))[-1]
    return 1e3 * float(np.hypot(*(np.array(static_tip(static(build_rod(actuator, rods)), *u)) - exact)))


@pytest.mark.parametrize("u", TORQUES, ids=str)
@pytest.mark.parametrize("load", LOADS)
def test_a_body_by_EI_comes_to_the_exact_one_with_the_square_of_its_rods(load: str, u: tuple[float, float]) -> None:
    body = Actuator.model_validate({**BODY, **LOADS[load]})
    found = [off(body, rods, u) for rods in (10, 20, 40, 80)]
    assert found[0] < 2.0
    assert found[3] < 0.04
    for coarse, fine in itertools.pairwise(found):
        assert fine == pytest.approx(coarse / 4.0, rel=0.2, abs=2e-3)


def test_by_rods_no_number_of_rods_comes_to_the_exact_one() -> None:
    """As the paper's tables have it: the chambers end at the middles of rods 5 and 10 of 10."""
    by_rods = Actuator.model_validate({**BODY, "chambers": ((0, 5), (5, 10))})
    assert by_rods.chamber_arcs is None
    assert min(off(by_rods, rods, (0.045, -0.045)) for rods in (10, 40, 160)) > 30.0


def test_the_halves_are_taken_where_a_file_with_EI_says_nothing_of_its_chambers_and_only_there() -> None:
    halves = ((0.0, LENGTH / 2), (LENGTH / 2, LENGTH))
    assert Actuator.model_validate(BODY).chamber_arcs == halves
    told = ((0.0, 0.1), (0.1, 0.2))
    assert Actuator.model_validate({**BODY, "chamber_arcs": told}).chamber_arcs == told
    k = joint_stiffness((2.5e-3,), (), LENGTH, 10)
    table = {"name": "table", "mass": 0.02, "length": LENGTH, "k": tuple(k), "b": (1e-5,)}
    assert Actuator.model_validate(table).chamber_arcs is None
    assert by_joints(Actuator.model_validate(BODY)).chamber_arcs == halves
