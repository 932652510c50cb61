"""Faults injected into the twin through the server."""

import numpy as np

from controller.schema.messages import TwinFaults
from tests.server.live_server import TestServer, wait_for


def test_the_operator_hides_a_marker_of_the_running_twin_and_a_viewer_may_not(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    wanted = {**TwinFaults().model_dump(mode="json"), "marker_loss": 1.0, "rods": 1 << 5}
    assert viewer.put("/api/twin/faults", json=wanted).status_code == 403
    assert operator.put("/api/twin/faults", json={**wanted, "noise": 0.5}).status_code == 422
    with operator.live() as live:
        assert operator.put("/api/twin/faults", json=wanted).json() == wanted
        wait_for(lambda: live.frames and np.isnan(live.frames[-1]["markers"][5, 0]), "the lost marker")
        assert np.isfinite(live.frames[-1]["markers"][4]).all()
        live.wait("event", lambda event: "100 %" in event["text"] and event["level"] == "warning")
        assert viewer.get("/api/twin/faults").json() == wanted
        off = TwinFaults().model_dump(mode="json")
        assert operator.put("/api/twin/faults", json=off).json() == off
        wait_for(lambda: np.isfinite(live.frames[-1]["markers"]).all(), "all markers again")
