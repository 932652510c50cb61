"""The application as it is made: nothing that belongs to the start is left to the first request."""

from server.app import app
from tests.controller.drivers.effort import lines_run


def test_routes_are_built_with_the_application_and_not_in_the_event_loop() -> None:
    made = app._api.__wrapped__()

    def look() -> None:
        for route in made.routes:
            route.matches(app.NOWHERE)

    assert lines_run(look) == lines_run(look)
