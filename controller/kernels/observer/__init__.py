"""The force-based observer and what it is told."""
