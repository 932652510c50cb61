"""The rod: geometry, statics, both integrators, energy."""
