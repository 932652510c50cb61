"""Reference, feedforward, feedback, and the tick that joins them."""
