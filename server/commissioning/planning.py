"""What this room asks the planner for."""

from controller.schema.parameters import RigParameters


def rest_tip(rig: RigParameters) -> tuple[float, float]:
    """Where the model's tip is without torques (x, y) [m]."""
    from controller.build.statics import static_map
    from controller.kernels.model.equilibrium import make_scratch
    from controller.kernels.model.statics import static_tip

    smap = static_map(rig.actuator, rig.controller)
    x, y = static_tip(smap.statics, 0.0, 0.0, smap.scratch if hasattr(smap, "scratch") else make_scratch(10))
    return float(x), float(y)
