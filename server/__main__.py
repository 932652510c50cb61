"""`python -m server READY_FILE`: run one server with settings from the environment; see `tendril serve`."""

import ctypes
import logging
import os
import signal
import sys
from pathlib import Path

from controller.logs import log_json
from server.complaints import one_line_errors
from server.ready import announce_to
from server.run import run_server
from server.settings import ServerSettings

PR_SET_PDEATHSIG = 1
"""End with the process that started us, however it ended (prctl(2))."""

ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
logging.getLogger("httpx").setLevel(logging.WARNING)
if os.environ.get("TENDRIL_LOG_FORMAT") == "json":  # before the settings are read, which may be refused
    log_json("server")
with one_line_errors():
    run_server(ServerSettings(), announce_to(Path(sys.argv[1])))
