"""Where the tip should go: shapes, timing, reach."""
