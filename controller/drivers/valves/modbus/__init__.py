"""Valves behind Modbus TCP: a register map, of which that of Festo's VTEM is shipped (docs/modbus.md)."""
