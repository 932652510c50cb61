"""One HTML page with nothing outside it, fit to print: what every report is made of."""
