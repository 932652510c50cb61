"""Writing, reading and listing recordings (.rrd); the files themselves are in recordings/data."""
