"""The certificate with which https is served, checked before anything starts."""

import ssl
from pathlib import Path

from controller.errors import ParameterError
from server.settings import ServerSettings


def require_certificate(settings: ServerSettings) -> None:
    """Raise ParameterError, which names the setting and its file, unless both or neither of them can be used."""
    cert, key = settings.tls_cert, settings.tls_key
    if cert is None and key is None:
        return
    if cert is None or key is None:
        missing, given = ("tls-cert", "tls-key") if cert is None else ("tls-key", "tls-cert")
        raise ParameterError(f"{given} is given without {missing}: https needs both")
    for name, path in (("tls-cert", cert), ("tls-key", key)):
        _require_readable(name, path)
    _require_pair(cert, key)


def _require_readable(name: str, path: Path) -> None:
    try:
        path.read_bytes()
    except OSError as error:
        raise ParameterError(f"{name} = {path} cannot be read: {error.strerror}") from error


def _require_pair(cert: Path, key: Path) -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(cert, key, password="")  # a key with a password must not make us wait for a terminal
    except ssl.SSLError as error:
        reason = error.reason or "no PEM, or a key with a password"
        raise ParameterError(f"tls-cert = {cert} and tls-key = {key} cannot be used together: {reason}") from error
