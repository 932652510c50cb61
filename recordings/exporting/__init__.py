"""A recording's numbers as CSV, Parquet, MATLAB or MCAP file, or as a path to follow."""
