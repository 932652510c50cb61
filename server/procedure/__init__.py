"""Procedures: whatever takes the rig, does steps and gives it back."""
