"""The rows of the campaign, by what they break."""
