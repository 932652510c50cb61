"""A rig that is not there: a simulated plant in a process of its own that speaks the wires of real devices."""
