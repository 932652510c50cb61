"""The report of `tendril reproduce`: the paper's tables and figures, its numbers beside ours, as one page."""
