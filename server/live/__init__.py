"""The live socket: one frame for all viewers, what each says, and the status of everything slow."""
