"""The link between rig process and server: zenoh keys, and the two ends that speak over them."""

from controller.link.client import RigClient
from controller.link.keys import ENDLESS
from controller.link.planned import PlannedRows
from controller.link.rig_end import RigEnd, RigService

__all__ = ["ENDLESS", "PlannedRows", "RigClient", "RigEnd", "RigService"]
