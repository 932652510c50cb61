"""Rod model, observer, controller and the rig process.

numba keys its cache on one file only: a changed callee in another file would leave a stale caller. So the cache folder
is named by a hash of every source that is compiled, and it must be set before a kernel is declared, hence here.
"""

import atexit
import contextlib
import hashlib
import os
import shutil
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

_IMPORTED = ("arrays.py", "modes.py", "slot.py", "states.py")
"""Not compiled themselves, but kernels import them, and the numbers of three are compiled in."""


def compiled_sources() -> list[Path]:
    """All files on which the machine code of the kernels depends."""
    paths = sorted(Path(__file__).parent.rglob("*.py"))
    return [path for path in paths if path.name in _IMPORTED or _is_compiled(path.read_bytes())]


def _is_compiled(source: bytes) -> bool:
    return b"numba" in source or b"compiled" in source


def _cache_folder() -> str:
    """Folder of compiled kernels for exactly these sources, where they lie, and these library versions."""
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in compiled_sources()))
    digest.update(f"{Path(__file__)} {version('numba')} {version('numpy')}".encode())
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return _writable(Path(root, "tendril", "numba", digest.hexdigest()[:16]))


def _writable(folder: Path) -> str:
    """`folder`; where it takes nothing, a copy of it for this process alone: numba refuses to read such a one."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
        return str(folder)
    except OSError:
        copy = tempfile.mkdtemp(prefix="tendril-numba-")
        atexit.register(shutil.rmtree, copy, ignore_errors=True)
        with contextlib.suppress(OSError, shutil.Error):
            shutil.copytree(folder, copy, dirs_exist_ok=True)
        return copy


if "NUMBA_CACHE_DIR" not in os.environ:
    os.environ["NUMBA_CACHE_DIR"] = _cache_folder()
if "numba" in sys.modules:  # it read the environment when it was imported
    sys.modules["numba"].config.reload_config()
# The matrices here are small: threads of the linear algebra spin longer than they compute, on cores that others need.
# It reads this when numpy is imported, hence here, too.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
