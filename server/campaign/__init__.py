"""`tendril faults`: real processes, real faults, and what must become of them."""
