"""Plants behind one protocol; the twin is one of them.

A driver and the loop share two places only: the measurement mailbox, which the driver writes, and the newest telemetry
row, whose `pressure_cmd` the driver sends to the valves. The twin goes through the same two, but steps inside the loop.
"""

from controller.drivers.driver import Driver
from controller.drivers.twin import TwinDriver

__all__ = ["Driver", "TwinDriver"]
