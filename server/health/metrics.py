"""GET /metrics: every figure of the health strip, as Prometheus reads it. Taken when asked for, kept nowhere."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from prometheus_client import CollectorRegistry, ProcessCollector, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from controller.schema.modes import Mode
from server.access.lease import OperatorLease
from server.health.loop_health import LoopWatch
from server.http.answers import RefusedCounts
from server.http.given import given
from server.operate.pages import Pages
from server.recorder.client import RecorderClient
from server.rig.client import Rig
from server.rig.history import History

QUANTILES = (0.5, 0.99, 1.0)


@dataclass(frozen=True)
class Figures:
    """Whose figures these are."""

    rig: Rig
    history: History
    loop: LoopWatch
    pages: Pages[Any]
    lease: OperatorLease
    refused: RefusedCounts
    recorder: RecorderClient


class ServerCollector(Collector):
    """Reads the parts of one server."""

    def __init__(self, of: Figures) -> None:
        self._of = of

    def collect(self) -> Iterable[Metric]:
        """All families; those of the rig's rows only while it is connected."""
        yield from self._rig()
        yield from self._loop()
        yield from self._people()
        yield from self._recording()

    def describe(self) -> Iterable[Metric]:
        """Nothing beforehand: what there is depends on the rig."""
        return []

    def _rig(self) -> Iterator[Metric]:
        rig = self._of.rig
        yield gauge("rig_connected", "Whether the rig is heard.", rig.boot() is not None)
        yield gauge("rig_refuses", "Whether the rig takes no command from this server.", bool(rig.trouble))
        yield gauge("rig_age_seconds", "Since the last telemetry.", rig.age)
        yield gauge("link_rtt_seconds", "Median of the last commands to the rig's loop and back.", rig.round_trip)
        yield counter("link_lost_rows", "Ticks that never reached this server.", rig.lost_rows)

    def _loop(self) -> Iterator[Metric]:
        newest = self._of.history.newest
        if newest is None or self._of.rig.boot() is None:
            return
        row = newest[0]
        yield counter("loop_ticks", "Ticks of the rig's loop in this boot.", row["tick"] + 1)
        yield counter("loop_lost_ticks", "Slots of the grid that passed without a tick.", row["lost"])
        lateness = GaugeMetricFamily(
            "tendril_loop_lateness_seconds", "Wake-up after the deadline, last 10 s.", labels=["quantile"]
        )
        for quantile, value in zip(QUANTILES, self._of.loop.lateness(QUANTILES), strict=True):
            lateness.add_metric([f"{quantile:g}"], value)
        yield lateness
        modes = GaugeMetricFamily("tendril_rig_mode", "1 for the rig's mode, 0 for the others.", labels=["mode"])
        for mode in Mode:
            modes.add_metric([mode.name], float(row["mode"] == mode))
        yield modes

    def _people(self) -> Iterator[Metric]:
        pages, refused = self._of.pages, self._of.refused
        yield gauge("viewers", "Pages with a live socket.", len(pages.open))
        yield gauge("viewers_max", "As many as are allowed.", pages.seats)
        yield gauge("operated", "Whether someone holds the lease.", self._of.lease.holder is not None)
        requests = CounterMetricFamily("tendril_refused_requests", "Answers of 400 and above.", labels=["status"])
        for status, count in sorted(refused.requests.items()):
            requests.add_metric([str(status)], count)
        yield requests
        yield counter("refused_messages", "Messages refused on live sockets.", refused.messages)
        yield counter("refused_signatures", "Cookies that this server did not sign.", refused.signatures)

    def _recording(self) -> Iterator[Metric]:
        state = self._of.recorder.state()
        yield gauge("recording", "Whether a recording runs.", state.recording)
        yield gauge("recording_rows", "Rows of the running recording, or the last one.", state.rows)
        yield gauge("recording_gaps", "Ticks that are missing in it.", state.gaps)
        yield gauge("recording_failed", "Whether the last recording ended by itself.", bool(state.problem))


GivenFigures = Annotated[Figures, given(Figures)]


def registry(of: Figures) -> CollectorRegistry:
    """Of one server: its parts, and its process as `process_*`."""
    found = CollectorRegistry(auto_describe=False)
    found.register(ServerCollector(of))
    ProcessCollector(registry=found)
    return found


def exposition(of: Figures) -> bytes:
    """In Prometheus' text format."""
    return generate_latest(registry(of))


def gauge(name: str, text: str, value: float) -> Metric:
    """One number."""
    return GaugeMetricFamily(f"tendril_{name}", text, value=float(value))


def counter(name: str, text: str, value: float) -> Metric:
    """One number that only rises, until a restart."""
    return CounterMetricFamily(f"tendril_{name}", text, value=float(value))
