"""`python -m recordings.live FD NAME RIG`: the recorder of the settings that are read from FD.

NAME and RIG are for who looks at the list of processes.
"""

import logging
import os
import pickle
import signal
import sys

from controller.system.logs import log_json
from controller.system.memory import few_arenas
from recordings.live.host import Host

with os.fdopen(int(sys.argv[1]), "rb") as given:
    settings, refill, log_format = pickle.load(given)
few_arenas()
if log_format == "json":
    log_json("recorder")
else:
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
try:
    host = Host(settings, refill)
except OSError:  # another server was faster, and its recorder is ours, too
    sys.exit()
signal.signal(signal.SIGTERM, lambda *_: host.end())
signal.signal(signal.SIGINT, signal.SIG_IGN)
host.run()
logging.shutdown()
os._exit(0)  # rerun's own exit waits for a writer that has died, for ever
