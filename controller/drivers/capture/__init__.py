"""Motion capture and other sensors of shape, a device each."""
