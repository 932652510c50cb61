"""Limits of the health figures that a user may set, and the line in the log when one turns red."""
