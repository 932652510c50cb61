"""A process that replaces a file and never waits for the disk."""

import sys
from pathlib import Path

from controller.system.whole_file import write_whole

if __name__ == "__main__":
    write_whole(Path(sys.argv[1]), "new", lasting=False)
