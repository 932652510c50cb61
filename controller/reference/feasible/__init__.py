"""Rows within reach and within the limits of speed, acceleration and torque rate."""
