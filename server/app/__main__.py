"""`python -m server.app READY_FILE`: run one server with settings from the environment; see `tendril serve`."""

import ctypes
import logging
import os
import signal
import sys
from pathlib import Path

from controller.realtime.priority import prefer_process
from controller.realtime.settings import REFUSED
from controller.system.complaints import one_line_errors
from controller.system.logs import log_json
from server.app.ready import announce_to
from server.app.run import run_server
from server.settings import ServerSettings

PR_SET_PDEATHSIG = 1
"""prctl(2), Linux: be sent this signal when the thread that started this process ends, however that happens."""

ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)  # it is of no use without the one that started it
prefer_process()  # no E-STOP waits for a browser
logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
logging.getLogger("httpx").setLevel(logging.WARNING)
if os.environ.get("TENDRIL_LOG_FORMAT") == "json":  # before the settings are read, which may be refused
    log_json("server")
with one_line_errors(REFUSED):
    run_server(ServerSettings(), announce_to(Path(sys.argv[1])))
