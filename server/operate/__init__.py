"""From an operator to the rig: commands, E-STOP, the hand on the target, and who operates."""
