"""Another plant by a few words."""

import pytest

from controller.errors import ParameterError
from controller.research.experiments.plant_scale import scaled
from controller.schema.parameters import TwinParameters

pytestmark = pytest.mark.keyed()

TWIN = TwinParameters(zeta=0.3, friction=0.2, dead_time=0.05, marker_latency=0.004, marker_noise=1e-4)


def test_factors_multiply_and_times_are_added() -> None:
    other = scaled(TWIN, "k=1.1, b=2,torque=0.9,friction=0.5,noise=3,delay=0.01,latency=-0.004")
    assert other.stiffness_scale == pytest.approx(1.1 * TWIN.stiffness_scale)
    assert other.zeta == pytest.approx(0.6)
    assert other.torque_gain == pytest.approx([0.9 * gain for gain in TWIN.torque_gain])
    assert other.friction == pytest.approx(0.1)
    assert other.marker_noise == pytest.approx(3e-4)
    assert other.dead_time == pytest.approx(0.06)
    assert other.marker_latency == pytest.approx(0.0)


@pytest.mark.parametrize("text", ["", " ", "k=1", "delay=0"])
def test_nothing_changes_without_a_change(text: str) -> None:
    assert scaled(TWIN, text) == TWIN


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("mass=2", "'mass' is not one of k, b, zeta, torque, friction, noise, delay, latency"),
        ("k", "k = '' is not a finite number"),
        ("k=", "k = '' is not a finite number"),
        ("k=stiff", "k = 'stiff' is not a finite number"),
        ("delay=nan", "delay = 'nan' is not a finite number"),
        ("k=1.1;delay=0.01", "k = '1.1;delay=0.01' is not a finite number"),
        ("b=1.1,zeta=1.1", "zeta=1.1 changes zeta a second time"),
        ("k=3", "stiffness_scale = 3.0: Input should be less than or equal to 2"),
        ("delay=-0.06", "dead_time = -0.0.*: Input should be greater than or equal to 0"),
        ("delay=10", "dead_time = 10.05: Input should be less than or equal to 0.2"),
    ],
)
def test_what_is_wrong_is_named(text: str, complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint):
        scaled(TWIN, text)


def test_the_torque_of_a_cosserat_plant_is_its_own() -> None:
    changed = scaled(TwinParameters(plant="cosserat"), "torque=1.2,k=1.1")
    assert (changed.cosserat.torque_gain, changed.stiffness_scale) == ((1.2, 1.2), 1.1)
    assert changed.torque_gain == TwinParameters().torque_gain
