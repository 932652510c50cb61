"""The fault campaign: every fault is injected for real, and judged by the rig's ring and by what an operator sees."""
