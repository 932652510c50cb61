"""Tables of numbers in text: one grammar of columns and units for every file that is read (docs/tables.md)."""
