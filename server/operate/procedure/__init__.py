"""Procedures take the rig, do steps and give it back."""
