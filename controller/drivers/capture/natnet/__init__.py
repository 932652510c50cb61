"""NatNet, the wire of OptiTrack's Motive: 3.0, 3.1, 4.0 and 4.1, read by a parser of our own."""
