"""No device is here: only what needs none. Nothing stands in for one."""

import importlib.util
from typing import Any

import numpy as np
import pytest

from controller.drivers.device import DeviceError
from controller.errors import ParameterError
from tests.controller.drivers.commands import vented, wanted

if importlib.util.find_spec("nidaqmx") is None:
    pytest.skip("the package nidaqmx is not installed", allow_module_level=True)

from controller.drivers.valves.nidaq import NiDaq, vented_volts, volts_of

RAW = {"output_zero": 5.0, "opening_volts": 5.0}


@pytest.mark.process
def test_without_a_device_it_says_that_it_needs_hardware() -> None:
    device = NiDaq(NiDaq.Options(), (0, 1, 2, 3), False)
    with pytest.raises(DeviceError, match="needs hardware: "):
        device.open()
    device.close()
    device.close()


def test_setpoints_become_volts_within_the_outputs_limits() -> None:
    options = NiDaq.Options(output_zero=1.0, output_scale=50e3, output_max=6.0)
    volts = volts_of(wanted(np.array([0.0, 100e3, 1e12, -1e12])), options, False)
    assert volts.tolist() == [1.0, 3.0, 6.0, 0.0]


def test_openings_become_volts_about_the_shut_valve() -> None:
    options = NiDaq.Options(**RAW)
    volts = volts_of(wanted(openings=np.array([0.0, 1.0, -0.5, 9.0])), options, True)
    assert volts.tolist() == [5.0, 10.0, 2.5, 10.0]


@pytest.mark.parametrize("raw", [False, True])
def test_venting_and_what_is_not_finite_give_the_voltage_that_empties(raw: bool) -> None:
    options = NiDaq.Options(**RAW)
    rest = vented_volts(options, raw).tolist()
    assert rest == ([0.0] * 4 if raw else [5.0] * 4)
    assert volts_of(vented(), options, raw).tolist() == rest
    nothing = np.array([np.nan, 0.0, 0.0, 0.0])
    assert volts_of(wanted(nothing, nothing), options, raw).tolist() == rest


@pytest.mark.parametrize(
    ("options", "chambers", "raw", "text"),
    [
        ({}, (0, 1, 2, 4), False, r"there are channels 0 to 3"),
        ({}, (0, 1, 2, 3), True, r"output_min = 0 V: a valve exhausts at -5 V"),
    ],
)
def test_what_cannot_be_is_refused(options: dict[str, Any], chambers: tuple[int, ...], raw: bool, text: str) -> None:
    with pytest.raises(ParameterError, match=text):
        NiDaq(NiDaq.Options(**options), chambers, raw)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"output_min": 5.0, "output_max": 5.0}, r"output_min = 5 V is not below output_max = 5 V"),
        ({"output_zero": -1.0}, r"output_zero = -1 V is outside"),
        ({"outputs": ["ao0", "b", "c", "d"]}, r"outputs"),
        ({"outputs": ["Dev1/ao0"]}, r"outputs"),
        ({"dump_line": "line0"}, r"dump_line"),
    ],
)
def test_options_that_do_not_fit_are_refused(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        NiDaq.Options(**options)
