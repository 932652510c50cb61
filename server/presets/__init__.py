"""Named choices that outlive a session: gains, and the actuator that the rig is started with."""
