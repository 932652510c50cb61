"""Every number of a telemetry row in words: one name for each signal on the page, in recordings and in exports."""

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.parameters import BACKBONE_POINTS, SENSORS
from controller.schema.slot import SIGNALS

TITLES = {
    "p_ref": "reference",
    "p_meas": "measured tip",
    "p_hat": "observer tip",
    "error": "error",
    "residual": "observer residual",
    "pressure_meas": "pressure",
    "pressure_cmd": "pressure command",
    "u": "torque",
    "u_ff": "feedforward torque",
    "u_fb": "feedback torque",
    "u_hat": "observer torque",
    "integral": "error integral",
    "target": "target",
    "p_ref_dot": "reference velocity",
    "energy": "energy",
    "ledger": "energy balance",
    "power": "power",
    "markers": "markers",
    "backbone": "observer backbone",
    "twin_backbone": "twin backbone",
    "measurement_age": "measurement age",
    "operator_age": "operator age",
    "server_age": "server age",
    "step_ns": "step time",
    "lateness_ns": "wake-up lateness",
    "lost": "lost ticks",
    "tick": "tick",
    "slot": "time slot",
    "mode": "mode",
    "cause": "cause",
    "law": "law",
    "controller": "controller",
    "signals": "controller signal",
    "sensed": "sensors used",
    "saturated": "saturated",
    "reachable": "reachable",
    "reseats": "observer reseats",
    "t_ns": "time on the rig's clock",
    "command_n": "command number",
    "request_n": "request number",
    "request_cause": "request's cause",
    "presence": "presence counter",
}
"""Every field in words, in the order of the page's menu."""


CHAMBERS = ("u1+", "u1-", "u2+", "u2-")
"""A pair works against each other for each torque; in the order of every vector of chambers."""

_XY = ("x", "y")
_ELEMENTS = {
    **{name: ("u1", "u2") for name in ("u", "u_ff", "u_fb", "u_hat")},
    **{name: CHAMBERS for name in ("pressure_cmd", "pressure_meas")},
    "signals": tuple(str(n) for n in range(1, SIGNALS + 1)),
    "power": ("of damping", "of the pressures", "of the observer", "of the constraints"),
    "markers": tuple(f"rod {rod} {axis}" for rod in range(1, SENSORS + 1) for axis in _XY),
    **{
        name: tuple(f"{point}/{BACKBONE_POINTS - 1} L {axis}" for point in range(BACKBONE_POINTS) for axis in _XY)
        for name in ("backbone", "twin_backbone")
    },
}
"""Names of the elements of fields that are neither one number nor a vector of the plane, in C order."""


def elements(field: str) -> tuple[str, ...]:
    """Names of a field's elements, in C order; ("",) where it is one number."""
    return _ELEMENTS.get(field, _XY if record_dtype(Telemetry)[field].shape == (2,) else ("",))


def title(field: str, place: int | None = None) -> str:
    """Name of the element at `place` in C order, "measured tip x"; without one of the whole field."""
    return TITLES[field] if place is None else f"{TITLES[field]} {elements(field)[place]}".rstrip()
