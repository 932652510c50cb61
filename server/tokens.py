"""The two access tokens and the key that signs cookies, in one file that its owner alone can read."""

import secrets
from typing import Annotated, Literal, get_args

from pydantic import Field as Bounds
from pydantic import ValidationError

from controller.errors import ParameterError
from controller.layout import Model
from controller.whole_file import write_whole
from server.settings import ServerSettings

Role = Literal["operator", "viewer"]
"""What a token is good for: to operate (one session at a time, by the lease), or to look and stop."""
ROLES: tuple[Role, ...] = get_args(Role)


def new_token() -> str:
    """144 random bits that can be typed."""
    return secrets.token_urlsafe(18)


Token = Annotated[str, Bounds(min_length=1, max_length=200)]


class Secrets(Model):
    """Access tokens that people type, and the key that signs cookies."""

    token: Token
    """The operator's; the only one in files of older versions."""
    viewer_token: Token = Bounds(default_factory=new_token)
    key: str

    def of(self, role: Role) -> str:
        """The token of `role`."""
        return self.token if role == "operator" else self.viewer_token


class TokenFile:
    """`secrets.json` in the state folder, and the tokens given in the environment, which go first."""

    def __init__(self, settings: ServerSettings) -> None:
        self._path = settings.state / "secrets.json"
        given = {"token": settings.token, "viewer_token": settings.viewer_token}
        self._given = {name: value.get_secret_value() for name, value in given.items() if value is not None}

    def read(self) -> Secrets:
        """The tokens in force; the file is made, or completed, where it is not whole yet."""
        kept = self._kept()
        found = Secrets.model_validate(kept.model_dump() | self._given)
        if found.token == found.viewer_token:
            raise ParameterError("the operator's and the viewer's access token are the same: change one of them")
        return found

    def stamp(self) -> object:
        """Differs once the file was changed."""
        try:
            about = self._path.stat()
        except OSError:
            return None
        return about.st_mtime_ns, about.st_ino

    def renew(self, role: Role) -> str:
        """Make another token for `role` and keep it; sessions of the old one end."""
        name = _field(role)
        if name in self._given:
            raise ParameterError(f"the {role}'s token comes from TENDRIL_{name.upper()}: change it there")
        token = new_token()
        self._write(self._kept().model_copy(update={name: token}))
        return token

    def _kept(self) -> Secrets:
        if not self._path.exists():
            self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._write(Secrets(token=new_token(), key=secrets.token_urlsafe(32)))
        try:
            kept = Secrets.model_validate_json(self._path.read_bytes())
        except ValidationError as error:
            raise ParameterError(
                f"{self._path} is damaged; delete it, and everyone signs in with a new token"
            ) from error
        if (mode := self._path.stat().st_mode) & 0o077:
            raise ParameterError(
                f"{self._path} has mode {mode & 0o777:04o}, so others can read the tokens: chmod 600, then renew both"
            )
        if "viewer_token" not in kept.model_fields_set:  # of a version that knew operators only
            self._write(kept)
        return kept

    def _write(self, found: Secrets) -> None:
        write_whole(self._path, found.model_dump_json())


def load_secrets(settings: ServerSettings) -> Secrets:
    """The tokens in force; see `TokenFile.read`."""
    return TokenFile(settings).read()


def _field(role: Role) -> str:
    return "token" if role == "operator" else "viewer_token"
