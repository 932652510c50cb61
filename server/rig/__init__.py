"""The client of the rig: its link, its telemetry, its channels."""
