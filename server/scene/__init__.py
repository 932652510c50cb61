"""The 3D view: one live scene for all, and a session of its own for every frame that looks at it."""
