"""Valves and the pressure sensors at them, a device each."""
