"""The controllers that the slot may hold: each a kernel, the numbers it is tuned by, a name and where it is from."""
