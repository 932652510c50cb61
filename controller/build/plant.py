"""Whichever plant the parameters ask for."""

from controller.build.cosserat import build_cosserat
from controller.build.twin import build_twin
from controller.kernels.plant.step import Plant
from controller.schema.parameters import RigParameters


def build_plant(parameters: RigParameters) -> Plant:
    """The simulated plant that `parameters` name, at rest; raises ParameterError where it cannot be built."""
    true = parameters.model_copy(update={"actuator": parameters.plant_actuator or parameters.actuator})
    return build_cosserat(true) if parameters.twin.plant == "cosserat" else build_twin(true)
