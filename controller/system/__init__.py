"""Files, processes, threads and logs."""
