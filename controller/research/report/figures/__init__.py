"""The figures of the report, one plate each."""
