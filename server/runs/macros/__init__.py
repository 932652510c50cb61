"""Macros: named lists of what an operator can do, run by one button and ended by any stop."""
