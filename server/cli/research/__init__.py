"""Commands that work on data and simulations and need no rig: one file each, their options in `commands`."""
