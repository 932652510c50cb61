"""The live socket: one beat for all viewers, what each says, and the status of everything slow."""
