"""What the page's plots ask of the server: channels of their choice, live and past, as numbers and as a table."""
