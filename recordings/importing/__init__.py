"""Paths that were measured elsewhere, as recordings."""
