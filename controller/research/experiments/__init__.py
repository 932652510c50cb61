"""Runs without a rig: simulation, benchmarks, the paper's tables."""
