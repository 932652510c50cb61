"""Plants behind one protocol; the twin is one of them."""
