"""The rig process: clock, ring, mailbox, priority, the 1 kHz loop and the pump beside it."""
