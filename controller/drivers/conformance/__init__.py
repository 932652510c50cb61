"""What every driver must keep to, tried the hard way: `tendril drivers check NAME` (docs/drivers.md)."""

from controller.drivers.conformance.bench import Bench, Driven
from controller.drivers.conformance.recorder import Recorder
from controller.drivers.conformance.suite import Row, check_driver

__all__ = ["Bench", "Driven", "Recorder", "Row", "check_driver"]
