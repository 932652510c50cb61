"""Settings of the server process."""

import ipaddress
from pathlib import Path
from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import Field as Bounds
from pydantic import SecretStr, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from controller.errors import spelled
from controller.system.keys import key_path, state_folder
from controller.system.logs import LogFormat
from recordings.format.messages import DISK_TIMEOUT_S, SPLIT_BYTES


class ServerSettings(BaseSettings):
    """What a server is started with; what no option of the command says, TENDRIL_<NAME> may."""

    model_config = SettingsConfigDict(env_prefix="TENDRIL_", extra="forbid", use_attribute_docstrings=True)

    host: str = "127.0.0.1"
    port: Annotated[int, Bounds(ge=0, le=65535)] = 8321
    """0 takes a free one."""
    endpoint: str = "tcp/127.0.0.1:7447"
    """Zenoh endpoint at which the rig listens."""
    rig: Annotated[str, spelled(r"^[\w-]{1,40}$", "1 to 40 letters, digits and _ -, no blanks")] = "twin"
    key_file: Path | None = None
    """File of the rig's key, without which nothing can be commanded; None: RIG.key in the folder `state`."""
    link_tls: Path | None = None
    """Folder of the certificates for an endpoint tls/...; see `controller.link.keys.open_session`."""
    recordings: Path | None = None
    """Folder of the .rrd files; the default is chosen by the recordings package."""
    state: Path = Bounds(default_factory=state_folder)
    """Folder of the tokens, the cookie key and the last settings."""
    token: SecretStr | None = None
    """The operator's access token; made at the first start and kept when not given."""
    viewer_token: SecretStr | None = None
    """The viewer's; likewise."""
    tls_cert: Path | None = None
    """Certificate chain (PEM) with which https is served; together with `tls_key`."""
    tls_key: Path | None = None
    """Its private key (PEM, without a password)."""
    allow_host: Annotated[str, spelled(r"^[\w.:,\[\]-]*$", "names of hosts, with commas between and no blanks")] = ""
    """Names by which browsers may ask for this server, besides its own; commas between them."""
    record_faults: bool = True
    """A FAULT or E-STOP under pressure is recorded by itself, with the 10 s before and after it."""
    recording_split: Annotated[int, Bounds(ge=1_000_000)] = SPLIT_BYTES
    """Bytes at which a recording goes on in another file."""
    disk_patience: Annotated[float, Bounds(ge=1.0, le=600.0)] = DISK_TIMEOUT_S
    """A disk that takes nothing for so long ends the recording [s]; until then the recorder's memory holds the rows."""
    recordings_quota: Annotated[int, Bounds(ge=0)] | None = None
    """Bytes of all recordings; the oldest ones go first. None: 50 GB, or 80 % of a smaller disk."""
    restarts: Path | None = None
    """File in which `tendril up` looks for another actuator to start its rig with; None: the rig is not its own."""
    rig_file: Path | None = None
    """The rig file with which `tendril up` started the rig; None: it was started without one."""
    allow_reach: str = ""
    """Devices, hosts and files that the page may put into the rig file beside those that it names; commas between them,
    and * for anything.
    """
    viewers_max: Annotated[int, Bounds(ge=1, le=10_000)] = 200
    """Pages with a live socket at the same time; the next one is refused, unless its session operates."""
    control_lapse: Annotated[float, Bounds(ge=2.0, le=60.0)] = 5.0
    """Control is free again when the operator's page gave no sign for so long [s]; what moves holds far sooner."""
    webhook: SecretStr | None = None
    """Address (http or https) to which a FAULT, an E-STOP and the end of a run are posted as JSON; None: none is."""
    log_format: LogFormat = "text"
    """Of what this process writes to its standard error."""
    rate_factor: Annotated[float, Bounds(gt=0.0, allow_inf_nan=False)] = 1.0
    """Multiplies how often one client may ask (`server/http/rates.py`); more where many people share one address."""
    frame_rate: Annotated[float, Bounds(ge=1.0, le=60.0)] = 60.0
    """Telemetry records a second that a page is sent at most; less over a slow line, or where software draws."""
    light_scene: bool = False
    """Leave out what software rendering is slow at (ground grid): for browser tests."""

    @model_validator(mode="after")
    def _webhook_can_be_asked(self) -> Self:
        """Of the whole, as the complaint about a field would quote it: an address may hold a secret."""
        if self.webhook is not None and not _is_http(self.webhook.get_secret_value()):
            raise ValueError("webhook: must be an address http://HOST... or https://HOST...")
        return self

    @property
    def key(self) -> Path:
        """The file of the rig's key."""
        return self.key_file or key_path(self.rig, self.state)

    @property
    def unprotected(self) -> bool:
        """Whether others can reach this server, and read along."""
        return exposed(self.host) and self.tls_cert is None


def _is_http(url: str) -> bool:
    try:
        parts = urlsplit(url)
        return parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:  # a port that is none, or half an address of IPv6
        return False


def exposed(host: str) -> bool:
    """Whether `host` can be reached from other machines."""
    return host != "localhost" and not is_loopback(host)


def is_loopback(address: str) -> bool:
    """Whether this is an address of the machine with itself."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False
