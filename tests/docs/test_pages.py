"""docs/live.md and docs/api.md against the code whose messages, bytes and routes they describe."""

import json
import re
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.system.origin import ROOT
from controller.text.markdown import filled
from server.app import tables
from server.http.answers import Problem
from server.http.rates import FLOOD, HEAVY, MESSAGE, SESSION
from server.live import hub, socket_handler
from server.live.hub import encode_frame
from server.live.messages import FromBrowser, FromServer
from server.plots.feed import CHUNK, encode_plot
from server.plots.messages import CHANNELS_MAX
from server.rig.history import BIN_TICKS, Bins
from tests.docs.blocks import blocks, rows_after

API, LIVE = ((ROOT / page).read_text() for page in (tables.API, tables.LIVE))
ROW = record_dtype(Telemetry)


def parts(message: bytes, heading: str, **sizes: int) -> dict[str, np.ndarray]:
    """What lies in `message` by the table after `heading`; nothing may be left over, and no byte belong to two."""
    found, end = {}, 0
    for offset, length, kind, about in rows_after(LIVE, heading):
        at, size = (eval(re.sub(r"(\d|n) (?=[nc])", r"\1*", text), {}, sizes) for text in (offset, length))
        assert at == end, (heading, about)
        end = at + size
        dtype = ROW if kind == "row" else np.dtype(kind).newbyteorder("<")
        name = found_name[1] if (found_name := re.match(r"`(\w+)`", about)) else kind
        found[name] = np.frombuffer(message[at:end], dtype)
    assert end == len(message), heading
    return found


def test_a_frame_has_the_bytes_of_its_table() -> None:
    row = np.zeros(1, ROW)
    row["tick"], row["p_meas"] = 7, (0.1, -0.2)
    found = parts(encode_frame(row), "**FRAME** (1)")
    assert (found["kind"].item(), found["count"].item()) == (1, 1)
    assert found["row"].tobytes() == row.tobytes()


def test_a_plot_has_the_bytes_of_its_table() -> None:
    n, c = 5, 3
    numbers = np.random.default_rng(0).normal(size=(2, n, c)).astype(np.float32)
    bins = Bins(40, [2, 9, 4], np.arange(n) * 0.016, *numbers)
    found = parts(encode_plot(bins), "**PLOT** (2)", n=n, c=c)
    assert [found[name].item() for name in ("kind", "count", "columns", "first")] == [2, n, c, 40]
    assert found["t"].tolist() == bins.t.tolist() and found["channel"].tolist() == bins.columns
    assert np.array_equal(found["low"].reshape(n, c), bins.low)
    assert np.array_equal(found["high"].reshape(n, c), bins.high)


@pytest.mark.parametrize(
    ("heading", "union"), [("## What the server says as text", FromServer), ("## What you say as text", FromBrowser)]
)
def test_every_message_is_there_with_its_fields(heading: str, union: Any) -> None:
    said = {kind.strip("`"): re.findall(r"`(\w+)`", fields) for kind, fields, *_ in rows_after(LIVE, heading)}
    models = get_args(get_args(union)[0])
    fields = {get_args(one.model_fields["type"].annotation)[0]: list(one.model_fields) for one in models}
    assert said == {kind: [name for name in names if name != "type"] for kind, names in fields.items()}


def test_bounds_are_those_of_the_code() -> None:
    for text in (
        f"{MESSAGE.burst} at once, {MESSAGE.per_second} a second; what is beyond",
        f"{FLOOD.burst} at once, {FLOOD.per_second} a second; beyond, 1008",
        f"| {socket_handler.MESSAGE_MAX_CHARS} characters |",
        f"more than {hub.VIEWERS_ALL_BEATS_MAX} viewers",
        f"the last {hub.WAITING} messages",
        f"n, {CHUNK} at most",
        f"bins of {BIN_TICKS} ms",
        f"{CHANNELS_MAX} at most",
    ):
        assert text in LIVE, text
    assert f"ask {SESSION.burst} times at once and {SESSION.per_second} times a second" in API
    assert f"heavy, {HEAVY.burst} at once and {HEAVY.per_second} a second" in API


def test_generated_tables_are_todays() -> None:
    assert filled(LIVE, "layout", tables.layout()) == LIVE
    assert filled(API, "routes", tables.routes()) == API


def test_refusals_have_the_form_that_is_shown() -> None:
    shown = [json.loads(block.text) for block in blocks(Path(ROOT / tables.API)) if block.kind == "json"]
    assert [type(Problem.model_validate(one).detail) for one in shown] == [str, list]
