"""A valve board on a serial line: docs/serial.md from the host's side."""
