"""A server with a rig file, and the page of its operator, as the tests of the commissioning use them."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from controller.schema.commissioned import StepName
from controller.schema.hardware import DriverStatus
from controller.schema.modes import Law, Mode
from controller.schema.rig_file import RigFile, noted, read_rig_file
from tests.server.live_server import Live, Page, TestServer, free_environment, taken, wait_for

RIG = """# our bench
name = "test"
[motion_capture]
driver = "natnet"
options = { server = "127.0.0.1" }
rods = [5, 10]
[valves]
driver = "serial"
options = { port = "/dev/ttyNONE" }  # at the left side
"""


class Bench:
    """A server with a rig file, its operator's page, and what that is told."""

    def __init__(self, server: TestServer, file: Path) -> None:
        self.server, self.file = server, file
        self.page: Page = server.operator()
        self.live: Live = Live(self.page.connect("/ws/live"))
        self.live.operate()
        self.live.wait_mode(Mode.VENTED)

    def state(self) -> dict[str, Any]:
        found: dict[str, Any] = taken(self.page.get("/api/commissioning")).json()
        return found

    def step(self, name: str) -> dict[str, Any]:
        return next(step for step in self.state()["steps"] if step["name"] == name)

    def post(self, step: str, what: str, **body: Any) -> Any:
        return self.page.post(f"/api/commissioning/{step}/{what}", json=body if what == "start" else None)

    def start(self, step: str, **body: Any) -> None:
        taken(self.post(step, "start", **body))

    def ended(self, step: str) -> dict[str, Any]:
        wait_for(lambda: self.state()["running"] is None, f"the end of {step}")
        return self.step(step)

    def done(self, step: str, **body: Any) -> dict[str, Any]:
        """The step from start to end, with a result that is good."""
        self.start(step, **body)
        found = self.ended(step)
        assert found["state"] == "done", found["result"]
        return found

    def wait_doing(self, what: str) -> None:
        def doing() -> bool:
            running = self.state()["running"]
            assert running is not None, self.state()
            return what in running["doing"]

        wait_for(doing, what)

    def put_back(self) -> bool:
        found = self.page.get("/api/settings").json()
        return (found["law"], found["sensed"], found["u_open"]) == (Law.FF_PI, 1 << 9, [0.0, 0.0])

    def rig(self) -> RigFile:
        return read_rig_file(self.file)

    def accepted(self, *steps: StepName) -> None:
        """As if these had been accepted."""
        lines = "".join(f'{step} = "accepted before"\n' for step in steps)
        self.file.write_text(noted(f"{RIG}[commissioned]\n{lines}", self.file, *steps))


@contextmanager
def bench_of(endpoint: str, folder: Path) -> Iterator[Bench]:
    free_environment()
    file = folder / "rig.toml"
    file.write_text(RIG)
    server = TestServer(folder, endpoint, rig_file=file, restarts=folder / "restarts.json")
    try:
        bench = Bench(server, file)
        try:
            yield bench
        finally:
            bench.live.close()
    finally:
        server.close()


def driver_status(role: str, values: dict[str, Any]) -> DriverStatus:
    """Of a device that runs and shows `values`."""
    return DriverStatus.model_validate(
        {
            "role": role, "driver": role, "device": "there", "state": "running", "detail": "", "capabilities": (),
            "rate": 200.0, "age": 0.0, "latency": 0.0, "clock": "two-way", "clock_offset": 0.0, "frames": 0, "lost": 0,
            "rejected": 0, "reconnects": 0, "values": values,
        }
    )  # fmt: skip
