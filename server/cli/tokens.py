"""The access tokens, shown and changed; a running server takes a new one over within a second."""

from typing import Annotated, Literal

import typer

from server.cli.typed import commands

app = commands(no_args_is_help=True, help=__doc__)

Whose = Annotated[Literal["operator", "viewer"] | None, typer.Argument(help="Whose; both without it.")]


@app.command()
def show(whose: Whose = None) -> None:
    """Print the access tokens in force; they are made where there are none yet."""
    from server.access.tokens import TokenFile
    from server.http.who import ROLES
    from server.settings import ServerSettings

    found = TokenFile(ServerSettings()).made()
    for role in [whose] if whose else ROLES:
        _print(role, found.of(role))


@app.command()
def new(whose: Whose = None) -> None:
    """Make another token; who signed in with the old one is signed out, and no one else."""
    from server.access.tokens import TokenFile
    from server.http.who import ROLES
    from server.settings import ServerSettings

    file = TokenFile(ServerSettings())
    for role in [whose] if whose else ROLES:
        _print(role, file.renew(role))


def _print(role: str, token: str) -> None:
    typer.echo(f"{role}: {token}")
