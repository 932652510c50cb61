"""The tick without a clock: runs, their figures, the recorded live path. The live product may use it."""
