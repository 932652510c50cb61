"""The twin of a user's own actuator is that actuator: what was fitted to the paper's three is theirs alone."""

import warnings

import pytest

from controller.assembly.rod import build_rod
from controller.assembly.stability import slowest
from controller.assembly.twin import build_twin, twin_model
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.parameters import RigParameters, TwinParameters, usual_twin
from tests.controller.own_arms import checked

pytestmark = pytest.mark.keyed()

ARMS = 60
SMALL = Actuator(name="small", mass=0.045, length=0.12, EI=(2.6e-3,), beta=6.8e-3, alpha=0.0)
TABLE = Actuator(name="table", mass=0.125, length=0.253, k=(0.0664, 0.0248), b=(5e-4,))
FEW = TABLE.model_copy(update={"table_rods": 2, "chambers": ((0, 1), (1, 2))})
FITTED = TwinParameters()


def test_arms_drawn_at_random_swing_as_their_files_say_or_are_refused_for_what_topples_them() -> None:
    """`python -m tests.controller.own_arms` does the same with a thousand."""
    found = [checked(seed) for seed in range(ARMS)]
    for one in found:
        assert not one.refused or one.refused.startswith("gravity = ("), one.refused
        assert one.frequency == pytest.approx(1.0, abs=0.02)
        assert one.zeta == pytest.approx(1.0, abs=0.02)
    assert sum(not one.refused for one in found) > 0.75 * ARMS


@pytest.mark.parametrize("arm", [SMALL, TABLE, FEW], ids=lambda arm: arm.name)
def test_its_first_mode_is_the_file_s(arm: Actuator) -> None:
    rig = RigParameters(actuator=arm)
    build_twin(rig)
    omega, zeta = slowest(build_rod(arm, arm.table_rods))
    assert slowest(twin_model(arm, rig.twin)) == pytest.approx((omega, zeta), rel=0.02)


def test_a_light_short_arm_has_its_own_3_hz() -> None:
    omega, zeta = slowest(twin_model(SMALL, RigParameters(actuator=SMALL).twin))
    assert (omega / 6.2832, zeta) == (pytest.approx(3.22, abs=0.02), pytest.approx(0.069, abs=0.002))


@pytest.mark.parametrize("name", PRESETS)
def test_of_the_paper_s_three_it_is_the_fit_s_whatever_torques_valves_allow(name: str) -> None:
    weaker = PRESETS[name].model_copy(update={"u_max": 0.01})
    for actuator in (PRESETS[name], weaker):
        assert RigParameters(actuator=actuator).twin == FITTED
    softer = PRESETS[name].model_copy(update={"k": tuple(0.8 * k for k in PRESETS[name].k)})
    assert usual_twin(softer).kappa == 1.0


def test_numbers_that_were_given_are_kept_and_the_others_are_the_file_s() -> None:
    twin = RigParameters(actuator=TABLE, twin=TwinParameters(kappa=12.0, friction=0.1)).twin
    assert (twin.kappa, twin.friction, twin.zeta, twin.creep) == (12.0, 0.1, None, (0.0, 0.0))
    assert RigParameters.model_validate_json(RigParameters(actuator=TABLE, twin=twin).model_dump_json()).twin == twin


def test_another_actuator_brings_what_is_usual_with_it_and_keeps_what_was_given() -> None:
    rig = RigParameters(twin=TwinParameters(friction=0.3, marker_noise=1e-3))
    other = rig.with_actuator(TABLE).twin
    assert (other.kappa, other.zeta, other.friction, other.marker_noise) == (1.0, None, 0.3, 1e-3)
    assert rig.with_actuator(TABLE).with_actuator(PRESETS["P2"]).twin == rig.twin


def test_the_twin_is_that_of_the_body_that_is_simulated() -> None:
    assert RigParameters(plant_actuator=TABLE).twin.kappa == 1.0
    assert RigParameters(actuator=TABLE, plant_actuator=PRESETS["P1"]).twin == FITTED


def test_an_actuator_by_EI_that_is_made_in_python_has_its_joints() -> None:
    with warnings.catch_warnings(action="error"):
        made = Actuator(name="made", mass=0.1, length=0.2, EI=(2e-3,), beta=1e-3)
    assert made == Actuator.model_validate({"name": "made", "mass": 0.1, "length": 0.2, "EI": [2e-3], "beta": 1e-3})
    assert len(made.k) == 10 and made.k[5] == pytest.approx(2e-3 / 0.02)
