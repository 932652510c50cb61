"""Rod model, observer, controller and the rig process.

numba keys its cache on one file only: a changed callee in another file would leave a stale caller. So the cache folder
is named by a hash of every source that is compiled, and it must be set before a kernel is declared, hence here.
"""

import hashlib
import os
import sys
from importlib.metadata import version
from pathlib import Path

_CONSTANTS = ("modes.py", "states.py")
"""Not compiled themselves, but their numbers are compiled into the kernels."""


def compiled_sources() -> list[Path]:
    """All files on which the machine code of the kernels depends."""
    paths = sorted(Path(__file__).parent.rglob("*.py"))
    return [path for path in paths if path.name in _CONSTANTS or _is_compiled(path.read_bytes())]


def _is_compiled(source: bytes) -> bool:
    return b"numba" in source or b"compiled" in source


def _cache_folder() -> str:
    """Folder of compiled kernels for exactly these sources and these library versions."""
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in compiled_sources()))
    digest.update(f"{version('numba')} {version('numpy')}".encode())
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return str(Path(root, "tendril", "numba", digest.hexdigest()[:16]))


os.environ.setdefault("NUMBA_CACHE_DIR", _cache_folder())
if "numba" in sys.modules:  # it read the environment when it was imported
    sys.modules["numba"].config.reload_config()
