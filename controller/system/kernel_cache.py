"""numba's cache on disk, so that nothing lying in it stops a start: what is not whole is compiled again.

numba writes its files without waiting for the disk and believes whatever it finds: after a power cut, pages of zeros.
"""

import logging
import pickle
import zlib
from pathlib import Path
from typing import Any, BinaryIO

from controller.numba_internals import caching
from controller.system.whole_file import open_regular

log = logging.getLogger(__name__)

CHECK_BYTES = 4


class CheckedFile(caching.IndexDataCacheFile):  # type: ignore[misc]
    """An index and its machine code, each with a checksum at its end, which `pickle` does not read."""

    def save(self, key: Any, data: Any) -> None:
        """As numba, but a folder that takes nothing costs time at the next start and nothing now."""
        try:
            super().save(key, data)
        except OSError as error:
            log.warning("a compiled kernel cannot be kept: %s", error)

    def _dump(self, obj: Any) -> bytes:
        data: bytes = super()._dump(obj)
        return data + zlib.crc32(data).to_bytes(CHECK_BYTES)

    def _load_index(self) -> Any:
        try:
            with open_regular(Path(self._index_path)) as file:
                pickle.load(file)
                _require_whole(file)
            return super()._load_index()
        except FileNotFoundError:
            return {}
        except Exception as error:  # random bytes raise whatever pickle makes of them
            log.warning("%s cannot be used, so its kernels are compiled again: %s", self._index_path, error)
            return {}

    def _load_data(self, name: str) -> Any:
        try:
            with open_regular(Path(self._data_path(name))) as file:
                _require_whole(file)
        except FileNotFoundError:
            raise
        except (OSError, ValueError) as error:
            log.warning("%s cannot be used, so its kernel is compiled again: %s", name, error)
            raise OSError(str(error)) from error  # which numba takes for a file that is gone
        return super()._load_data(name)


def use() -> None:
    """Have every kernel that is declared from now on kept in such files."""
    caching.IndexDataCacheFile = CheckedFile


def _require_whole(file: BinaryIO) -> None:
    """ValueError unless the rest of `file` ends with its checksum."""
    rest = file.read()
    if zlib.crc32(rest[:-CHECK_BYTES]).to_bytes(CHECK_BYTES) != rest[-CHECK_BYTES:]:
        raise ValueError("its checksum is wrong")
