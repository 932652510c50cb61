"""What every request and answer is made of: who asks, what it is given, and every "no"."""
