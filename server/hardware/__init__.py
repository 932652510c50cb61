"""Rigs of real devices: how their drivers fare, and the rig file."""
