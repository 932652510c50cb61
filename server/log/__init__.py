"""What happened: the event log, the audit log, and what was refused."""
