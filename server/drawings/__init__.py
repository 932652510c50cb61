"""Drawn references: what the page sends, how it is planned, foreseen and kept."""
