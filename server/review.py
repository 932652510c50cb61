"""Slow preparations for the Review tab, off everyone's path: rerun's viewer is extracted once, broken files mended."""

import logging
import threading
from pathlib import Path

from controller.errors import TendrilError
from recordings.store import Store
from recordings.viewer import viewer_files

log = logging.getLogger(__name__)


class Review:
    """Runs in a thread from the start of the server; `viewer` is None until rerun's files are there."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self.viewer: Path | None = None
        self.problem = ""
        threading.Thread(target=self._prepare, name="review", daemon=True).start()

    def _prepare(self) -> None:
        try:
            self.viewer = viewer_files()
        except (TendrilError, OSError) as error:
            self.problem = str(error)
            log.warning("rerun's viewer cannot be served: %s", error)
        for broken in self._store.broken():
            try:
                self._store.repair(broken)
            except (TendrilError, OSError) as error:
                log.warning("recording %s cannot be mended: %s", broken, error)
