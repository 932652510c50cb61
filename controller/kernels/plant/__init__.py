"""The twin: chambers, valves, friction, noise, faults."""
