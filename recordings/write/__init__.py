"""The recorder: rows in, a file on the disk."""
