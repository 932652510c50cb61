"""Plants behind one protocol: the twin, and rigs of real devices.

A driver and the loop share two mailboxes only: measurements, which the driver writes, and valve commands, which it
reads. The twin goes through the first, too, but steps inside the loop. Nothing is imported here: a device's module must
not need the kernels.
"""
