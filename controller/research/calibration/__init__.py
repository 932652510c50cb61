"""The twin's unknowns and the unpublished gains, fitted to a named part of the paper's table."""
