"""`tendril up`: rig and server as children that are kept alive."""
