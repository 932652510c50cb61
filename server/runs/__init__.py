"""Runs of a reference on the rig: planned from where the reference is now, tracked, watched tick by tick, judged."""
