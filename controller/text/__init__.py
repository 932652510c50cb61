"""What is read and written as text: tables of numbers (docs/tables.md), TOML, the page of a report, tables in docs/."""
