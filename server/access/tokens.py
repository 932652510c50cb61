"""The two access tokens and the key that signs cookies, in one file that its owner alone can read."""

import logging
import secrets
from contextlib import suppress
from typing import Annotated

from pydantic import Field as Bounds
from pydantic import ValidationError

from controller.errors import ParameterError, TendrilError
from controller.schema.layout import Model
from controller.system.whole_file import NotRegular, read_whole, set_aside, write_new, write_whole
from server.http.who import Role
from server.settings import ServerSettings

log = logging.getLogger(__name__)


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


GUESSABLE = 12
"""Characters of a given token below which the log warns: a right one is always let in, so nothing but its length keeps
it from being guessed.
"""


class Damaged(ParameterError):
    """The file of the tokens holds something else."""


class TokenFile:
    """`secrets.json` in the state folder, and the tokens given in the environment, which go first."""

    def __init__(self, settings: ServerSettings) -> None:
        self._path = settings.state / "secrets.json"
        given = {"token": settings.token, "viewer_token": settings.viewer_token}
        self._given = {name: value.get_secret_value() for name, value in given.items() if value is not None}

    def made(self) -> Secrets:
        """As `read`, for a start: a file that is missing or damaged stops none, it is made again with other tokens.

        Where it cannot be kept they hold for this process alone, and the log says so.
        """
        for name, token in self._given.items():
            if len(token) < GUESSABLE:
                told = f"TENDRIL_{name.upper()} has {len(token)} characters"
                log.warning("%s: guesses are heard without end, take %d random ones or more", told, GUESSABLE)
        try:
            return self._in_force(self._kept())
        except FileNotFoundError:
            return self._anew()
        except (Damaged, NotRegular) as error:
            aside = set_aside(self._path)
            kept = f"it is {aside} now" if aside else "it cannot be renamed"
            log.warning("%s; %s, and everyone signs in with a new token", error, kept)
            return self._anew()
        except OSError as error:  # it may be as good as ever, but not for us
            log.warning("%s cannot be read, so this server has tokens of its own: %s", *_why(error))
            return self._in_force(_fresh())

    def _anew(self) -> Secrets:
        fresh = _fresh()
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            write_new(self._path, fresh.model_dump_json().encode())
        except FileExistsError:  # another process was first
            return self.read()
        except OSError as error:
            log.warning("the access tokens will not outlive this server, as %s cannot be written: %s", *_why(error))
        return self._in_force(fresh)

    def read(self) -> Secrets:
        """The tokens in force; OSError where the file cannot be read, Damaged or ParameterError where it may not be."""
        return self._in_force(self._kept())

    def _in_force(self, kept: Secrets) -> Secrets:
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
        self.made()
        try:
            self._write(self._kept().model_copy(update={name: token}))
        except OSError as error:
            raise TendrilError("the token stays as it was, as {} cannot be written: {}".format(*_why(error))) from error
        return token

    def _kept(self) -> Secrets:
        text = read_whole(self._path)
        try:
            kept = Secrets.model_validate_json(text)
        except ValidationError as error:
            raise Damaged(f"{self._path} is damaged") from error
        if (mode := self._path.stat().st_mode) & 0o077:
            raise ParameterError(
                f"{self._path} has mode {mode & 0o777:04o}, so others can read the tokens: chmod 600, then renew both"
            )
        if "viewer_token" not in kept.model_fields_set:  # of a version that knew operators only
            with suppress(OSError):
                self._write(kept)
        return kept

    def _write(self, found: Secrets) -> None:
        write_whole(self._path, found.model_dump_json())


def load_secrets(settings: ServerSettings) -> Secrets:
    """The tokens in force; see `TokenFile.made`."""
    return TokenFile(settings).made()


def _fresh() -> Secrets:
    return Secrets(token=new_token(), key=secrets.token_urlsafe(32))


def _why(error: OSError) -> tuple[str, str]:
    return str(error.filename), error.strerror or str(error)


def _field(role: Role) -> str:
    return "token" if role == "operator" else "viewer_token"
