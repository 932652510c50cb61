"""Paths that are learned by repeating them: what a run saw, and what is kept of it for the next one."""
