"""What the server does again and again: each with a period of its own, and nothing that only compares with before."""

from tests.server.live_server import TestServer

WITH_ROWS = 0.02
"""Least pace [s]; these are called as rows come, 60 times a second."""
PERIODS = {
    "the procedure under way": WITH_ROWS,
    "automatic recordings": WITH_ROWS,
    "the live sockets": WITH_ROWS,
    "rig, lease and settings": 0.05,
    "the news of the status": 0.05,
    "the access tokens": 0.1,
    "the recorder": 0.1,
    "another actuator": 0.25,
    "the server's own health": 0.5,
    "the alarms": 1.0,
    "the event log": 1.0,
    "the audit log": 1.0,
    "exports that are fetched too late": 10.0,
    "the recordings' size": 60.0,
}


def test_every_job_of_the_server_is_listed_here_with_its_period(server: TestServer) -> None:
    assert {job.name: job.period for job in server.services.scheduler.jobs.values()} == PERIODS
