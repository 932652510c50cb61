"""`python -m server` is the command `tendril`, by whatever name it is found."""

from server.cli.main import main

main()
