"""The E-STOP's own ways: by the live socket and by HTTP, from anyone, whatever else waits."""

import pytest

from controller.modes import Mode
from tests.server.live_server import VIEWER_TOKEN, TestServer


def test_anyone_stops_by_the_socket_and_is_answered_with_the_number(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    assert operator.command("arm").status_code == 200
    with viewer.live() as live:
        live.send(type="e_stop", n=7)
        answer = live.wait("reply")
        assert (answer["n"], answer["id"], answer["reply"]["accepted"]) == (7, 0, True)
        assert answer["reply"]["mode"] == Mode.E_STOP
        live.wait_mode(Mode.E_STOP)
        live.wait("event", lambda m: m["text"].endswith("e-stop"))


def test_a_stop_passes_on_a_socket_whose_messages_are_dropped(server: TestServer) -> None:
    operator = server.operator()
    assert operator.command("arm").status_code == 200
    with operator.live() as live:
        while server.services.rates.message(_id_of(server)).name == "HEARD":
            pass
        live.send(type="e_stop", n=1)
        assert live.wait("reply")["n"] == 1
        live.wait_mode(Mode.E_STOP)


@pytest.mark.parametrize("text", ['{"type": "e_stop"}', '{"type": "e_stop", "n": -1}', '{"type": "e_stop", "n": "x"}'])
def test_a_malformed_stop_is_refused_by_name(text: str, server: TestServer) -> None:
    with server.page().sign_in().live() as live:
        live.socket.send(text)
        assert "e_stop.n" in live.wait("refused")["detail"]


def _id_of(server: TestServer) -> str:
    holder = server.services.lease.holder
    assert holder is not None
    return holder.id
