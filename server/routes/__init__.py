"""REST routes, three lines each."""
