"""References: the library, and what is drawn or imported."""
