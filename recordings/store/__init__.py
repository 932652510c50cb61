"""The folder of recordings: list, change, mend, measure, delete."""
