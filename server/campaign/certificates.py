"""Certificates for a link over TLS on this machine, made as docs/two-machines.md says."""

import shutil
import subprocess
from pathlib import Path

from server.campaign.waiting import Skipped

DAYS = "2"
NAMES = "subjectAltName=IP:127.0.0.1,DNS:localhost\n"


def make_certificates(folder: Path) -> None:
    """ca.pem, cert.pem and key.pem in `folder`, which is made; `Skipped` where there is no openssl."""
    if shutil.which("openssl") is None:
        raise Skipped("no openssl here to make certificates with")
    folder.mkdir()
    (folder / "names.txt").write_text(NAMES)
    for command in (
        f"req -x509 -newkey rsa:2048 -nodes -days {DAYS} -subj /CN=tendril -keyout ca.key -out ca.pem",
        "req -newkey rsa:2048 -nodes -subj /CN=rig -keyout key.pem -out cert.csr",
        f"x509 -req -in cert.csr -CA ca.pem -CAkey ca.key -days {DAYS} -out cert.pem -extfile names.txt",
    ):
        subprocess.run(["openssl", *command.split()], cwd=folder, check=True, capture_output=True)
