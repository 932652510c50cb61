"""The page about what was found."""
