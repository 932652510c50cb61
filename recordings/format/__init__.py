"""What lies in an .rrd and beside it, and how it is laid out."""
