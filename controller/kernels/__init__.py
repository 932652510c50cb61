"""The paper, one equation a function: pure numba kernels that know only numbers and arrays."""
