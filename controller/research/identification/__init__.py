"""From measured data to the numbers of an actuator file, and the model run over recorded data."""
