"""The kernels beside other engines, and the live loop."""
