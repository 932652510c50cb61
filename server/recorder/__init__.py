"""Recordings: made by hand or by themselves, kept, looked at, exported."""
