"""A certificate for the loopback that no one has signed but itself."""

import subprocess
from pathlib import Path


def make_pair(folder: Path) -> tuple[Path, Path]:
    """Certificate and key in `folder`, good for two days."""
    cert, key = folder / "cert.pem", folder / "key.pem"
    names = ["-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1"]
    made = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", *names]
    subprocess.run([*made, "-keyout", key, "-out", cert], check=True, capture_output=True)
    return cert, key
