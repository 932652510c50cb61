"""From parameters to memory: rod, rig and twin, and whether they stand and are stable."""
