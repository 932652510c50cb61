"""From files back to numbers, figures and pictures."""
