"""`python -m tests.server.recorder.record_until_killed FOLDER ENDPOINT NAME`: a server that records; prints the id."""

import signal
import sys
from pathlib import Path

from tests.server.live_server import TestServer, free_environment, wait_for

if __name__ == "__main__":
    folder, endpoint, name = sys.argv[1:]
    free_environment()
    server = TestServer(Path(folder), endpoint, apart=True)
    page = server.operator()
    id = page.post("/api/recordings", json={"name": name}).json()["id"]
    wait_for(lambda: server.services.recorder.state().rows > 500, "rows")
    print(id, flush=True)
    signal.pause()
