"""`python -m controller.virtual RIG_FILE [PLANT]`: the virtual rig as a child process, told what to do line by line."""

import sys
from pathlib import Path

from controller.realtime.priority import prefer_process
from controller.system.complaints import one_line_errors
from controller.virtual.rig import run_virtual_rig

with one_line_errors():
    prefer_process()  # no real device waits for a browser
    run_virtual_rig(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "", None)
