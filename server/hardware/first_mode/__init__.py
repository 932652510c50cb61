"""The arm's first mode: measured on the running rig by small steps, kept for each actuator, assumed until then."""
