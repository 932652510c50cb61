"""Settings of the server process and its two secrets: access token and cookie key."""

import ipaddress
import secrets
from pathlib import Path
from typing import Annotated

from pydantic import Field as Bounds
from pydantic import SecretStr, ValidationError
from pydantic_settings import BaseSettings, SettingsConfigDict

from controller.errors import ParameterError
from controller.key_file import key_path, state_folder
from controller.layout import Model
from controller.whole_file import write_whole
from recordings.writer import SPLIT_BYTES


class ServerSettings(BaseSettings):
    """What a server is started with; every field can also be given as TENDRIL_<NAME> in the environment."""

    model_config = SettingsConfigDict(env_prefix="TENDRIL_", extra="forbid", use_attribute_docstrings=True)

    host: str = "127.0.0.1"
    port: Annotated[int, Bounds(ge=0, le=65535)] = 8321
    """0 takes a free one."""
    endpoint: str = "tcp/127.0.0.1:7447"
    """Zenoh endpoint at which the rig listens."""
    rig: Annotated[str, Bounds(pattern=r"^[\w-]{1,40}$")] = "twin"
    key_file: Path | None = None
    """File of the rig's key, without which nothing can be commanded; None: RIG.key in the folder `state`."""
    link_tls: Path | None = None
    """Folder of the certificates for an endpoint tls/...; see `controller.link.keys.open_session`."""
    recordings: Path | None = None
    """Folder of the .rrd files; the default is chosen by the recordings package."""
    state: Path = Bounds(default_factory=state_folder)
    """Folder of the token, the cookie key and the last settings."""
    token: SecretStr | None = None
    """Access token; made at the first start and kept when not given."""
    record_faults: bool = True
    """A FAULT or E-STOP under pressure is recorded by itself, with the 10 s before and after it."""
    recording_split: Annotated[int, Bounds(ge=1_000_000)] = SPLIT_BYTES
    """Bytes at which a recording goes on in another file."""
    recordings_quota: Annotated[int, Bounds(ge=0)] | None = None
    """Bytes of all recordings; the oldest ones go first. None: 50 GB, or 80 % of a smaller disk."""
    orders: Path | None = None
    """File in which `tendril up` looks for another actuator to start its rig with; None: the rig is not its own."""
    rate_factor: Annotated[float, Bounds(gt=0.0, allow_inf_nan=False)] = 1.0
    """Multiplies how often one client may ask (`server/rates.py`); more where many people share one address."""
    light_scene: bool = False
    """Leave out what software rendering is slow at (ground grid): for browser tests."""

    @property
    def key(self) -> Path:
        """The file of the rig's key."""
        return self.key_file or key_path(self.rig, self.state)


class Secrets(Model):
    """Access token that people type, and the key that signs cookies."""

    token: Annotated[str, Bounds(min_length=1, max_length=200)]
    key: str


def load_secrets(settings: ServerSettings) -> Secrets:
    """The stored secrets (made at the first start, readable by the user alone); a given token goes first."""
    path = settings.state / "secrets.json"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        fresh = Secrets(token=secrets.token_urlsafe(18), key=secrets.token_urlsafe(32))
        write_whole(path, fresh.model_dump_json())
    try:
        kept = Secrets.model_validate_json(path.read_bytes())
    except ValidationError as error:
        raise ParameterError(f"{path} is damaged; delete it, and everyone signs in with a new token") from error
    if settings.token is None:
        return kept
    return Secrets(token=settings.token.get_secret_value(), key=kept.key)


def exposed(host: str) -> bool:
    """Whether `host` can be reached from other machines."""
    if host == "localhost":
        return False
    try:
        return not ipaddress.ip_address(host).is_loopback
    except ValueError:
        return True
