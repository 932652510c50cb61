"""The application: every room joined, run, and ended in order."""
