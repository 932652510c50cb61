"""Word of a FAULT, an E-STOP or the end of a run for those who do not look at the page: the webhook."""
