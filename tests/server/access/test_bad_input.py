"""What no page sends, by hand: each is refused by a sentence that names what is wrong, and nothing is lost."""

from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from server.access.gate import BODY_MAX, UNCOUNTED_MAX
from tests.server.live_server import Page, RigProcess, TestServer, free_environment
from tests.waiting import wait_for

UNREADABLE = {
    "no Unicode": b'{"request": "\xff\xfe"}',
    "nested": b'{"request": ' + b"[" * 1900 + b"]" * 1900 + b"}",
    "digits": b'{"request": ' + b"9" * 4000 + b"}",
    "nothing": b"",
    "NUL": b"\x00" * 100,
    "half": b'{"request": "ar',
    "number": b"1e999",
    "a lone surrogate": b'{"request": "\\ud800"}',
}
CSV = {
    "empty": (b"", "required"),
    "one line": (b"t,x,y\n0,0,0\n", "at least 2 rows"),
    "no column y": (b"t,x\n0,0\n1,0\n", "column y is missing"),
    "two columns y": (b"t,x,y,y\n0,0,0,0\n1,0,0,0\n", "names y twice"),
    "nan": (b"t,x,y\n0,nan,0\n1,0,0\n", "line 2: x = nan is not finite"),
    "word": (b"t,x,y\n0,0,0\n1,zero,0\n", "line 3: x = 'zero' is not a number"),
    "far": (b"t,x,y\n0,0,0\n1,1e308,0\n", "line 3: x = 1e+308 m, more than 1000"),
    "late": (b"t,x,y\n0,0,0\n1e300,0,0\n", "line 3: t = 1e+300 s after the first line, more than 1e+06"),
    "falling": (b"t,x,y\n1,0,0\n0,0,0\n", "line 3: t = 0 s is not after 1 s"),
    "short row": (b"t,x,y\n0,0,0\n1,0\n", "line 3: 2 values, but y is column 3"),
    "no Unicode": (b"t,x,y\n0,\xff,0\n", "line 2: byte 0xff is not UTF-8: save it as CSV in UTF-8"),
    "NUL": (b"t,x,y\n0,\x00,0\n1,0,0\n", "line 2"),
    "many columns": (b"a," * 300_000 + b"b\n" + b"1\n" * 5, "and 299981 more"),
    "an .rrd": (b"RRF2\x00\x00\x00\x01PK\x03\x04" * 200, "the file"),
    "open quote": (b't,x,y\n0,"0,0\n' + b"1,0,0\n" * 5, "line 2"),
}
GOOD = {
    "BOM": b"\xef\xbb\xbft,x,y\n0,0,0\n1,0.1,0\n",
    "quotes": b'"t","x","y"\n"0","0","0"\n"1","0.1","0"\n',
    "decimal commas": b"t;x;y\n0;0,0;0\n1;0,1;0\n",
    "carriage returns": b"t,x,y\r\n0,0,0\r\n1,0.1,0\r\n",
}
TOML = {
    "nested arrays": ("a = " + "[" * 5000, "nested too deeply"),
    "deep keys": ("a." * 150_000 + "b = 1", "more than 10 parts"),
    "deep quoted keys": ('"a" . ' * 50_000 + "b = 1", "more than 10 parts"),
    "deep tables": ("[" + "a." * 150_000 + "b]", "more than 10 parts"),
    "digits": ("length = " + "9" * 5000, "not TOML"),
    "date": ("length = 2020-13-45", "not TOML"),
    "nan": ('name = "X"\nmass = nan', "mass = nan"),
    "long word": ("a" * 390_000, "not TOML"),
    "many keys": ("\n".join(f"k{n} = 1" for n in range(30_000)), "the file"),
}
NAMES = ("%2e%2e%2fsecrets", "%00", "a%00b", "a%2Fb", "%E2%80%AEtxt", "%FF", "x" * 3000, "CON%0A", "%C2%85")


@pytest.fixture(scope="module")
def server(shared_rig: RigProcess, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestServer]:
    """One for all: what is refused leaves it as it was."""
    free_environment()
    found = TestServer(tmp_path_factory.mktemp("server"), shared_rig.endpoint, rate_factor=1e6)
    yield found
    found.close()


@pytest.fixture(scope="module")
def page(server: TestServer) -> Page:
    return server.operator()


@pytest.fixture
def operator(page: Page) -> Page:
    """Operates again: its lease may have lapsed while another test took long."""
    return page.operate()


def refused(answer: httpx.Response, *statuses: int) -> str:
    """The text of a refusal with one of `statuses`."""
    assert answer.status_code in statuses, (answer.status_code, answer.text[:300])
    assert len(answer.content) < 50_000, "an answer is no echo"
    return str(answer.json()["detail"])


@pytest.mark.parametrize(
    ("method", "path", "body", "field"),
    [
        ("POST", "/api/command", {"request": "fly"}, ["body", "request"]),
        ("POST", "/api/command", {}, ["body", "request"]),
        ("POST", "/api/command", {"request": "arm", "more": 1}, ["body", "more"]),
        ("POST", "/api/command", {"request": "follow"}, ["body", "target"]),
        ("POST", "/api/command", {"request": "follow", "target": [0.1]}, ["body", "target", 1]),
        ("POST", "/api/command", {"request": "follow", "target": [0.1, 9.0]}, ["body", "target", 1]),
        ("POST", "/api/command", "[", None),
        ("POST", "/api/command", '{"request": "follow", "target": [NaN, 0]}', ["body", "target", 0]),
        ("POST", "/api/command", '{"request": "follow", "target": [Infinity, 0]}', ["body", "target", 0]),
        ("PATCH", "/api/settings", {"changes": {"K_P": [12.0, 0.1]}}, ["body", "changes", "K_P", 0]),
        ("PATCH", "/api/settings", {"changes": {"K_Q": 1}}, ["body", "changes", "K_Q"]),
        ("PATCH", "/api/settings", {"changes": {"sensed": 1024}}, ["body", "changes", "sensed"]),
        ("PATCH", "/api/settings", {"changes": {"law": 9}}, ["body", "changes", "law"]),
        ("PATCH", "/api/settings", '{"changes": {"u_open": [NaN, 0]}}', ["body", "changes", "u_open", 0]),
        ("PATCH", "/api/settings", {"K_P": [0.1, 0.1]}, ["body", "changes"]),
        ("POST", "/api/recordings", {"name": "x" * 81}, ["body", "name"]),
        ("POST", "/api/session", {"token": ""}, ["body", "token"]),
        ("POST", "/api/session", '{"token": "\\ud800"}', ["body", "token"]),
    ],
)
def test_malformed_bodies_get_422_with_the_field_named(
    method: str, path: str, body: Any, field: list[Any] | None, server: TestServer, operator: Page
) -> None:
    before = server.services.operator.settings
    given = {"content": body, "headers": {"content-type": "application/json"}} if isinstance(body, str) else {}
    answer = operator.request(method, path, **(given or {"json": body}))
    assert answer.status_code == 422, answer.text
    if field:
        assert field in [item["loc"] for item in answer.json()["detail"]]
    assert server.services.operator.settings == before


def test_a_value_out_of_bounds_is_named_with_its_bound(operator: Page) -> None:
    item = operator.patch("/api/settings", json={"changes": {"K_P": [12.0, 0.1]}}).json()["detail"][0]
    assert (item["input"], item["ctx"]) == (12.0, {"le": 5.0})


@pytest.mark.parametrize("body", UNREADABLE.values(), ids=UNREADABLE)
def test_a_body_that_is_no_json_is_malformed_whatever_it_is(body: bytes, operator: Page) -> None:
    headers = {"content-type": "application/json"}
    for method, path in (("POST", "/api/command"), ("PATCH", "/api/settings"), ("POST", "/api/drawings/plan")):
        assert "body" in refused(operator.request(method, path, content=body, headers=headers), 422)


def test_a_field_that_is_named_twice_counts_with_the_last_in_the_log_too(server: TestServer, operator: Page) -> None:
    body = b'{"request": "arm", "request": "follow", "request": "hold", "target": [0, 0], "target": ["twice", 0]}'
    answer = operator.post("/api/command", content=body, headers={"content-type": "application/json"})
    assert "'loc': ['body', 'target', 0]" in refused(answer, 422)
    log = server.services.events  # which the application's loop writes: the network's has answered
    wait_for(lambda: any("hold refused: target.0" in event.text for event in list(log.recent)), "its line in the log")


def test_lists_without_end_are_refused_early_and_briefly(operator: Page) -> None:
    drawing = {"name": "x", "timing": {"kind": "fastest"}, "points": [[0, 0]] * 140_000}
    assert "at most 5000" in refused(operator.post("/api/drawings/plan", json=drawing), 422)
    assert "at most 16" in refused(operator.patch("/api/settings", json={"changes": {"K_P": [None] * 150_000}}), 422)
    many = {"changes": {f"k{n}": 1 for n in range(50_000)}}
    assert "at most 64" in refused(operator.patch("/api/settings", json=many), 422)
    lines = {"lines": [[["x", "y"]] * 5000] * 10}
    assert "lines" in refused(operator.put("/api/scene/abcdefgh/path/ghost", json=lines), 422)


def test_bodies_have_a_bound_and_a_command_a_small_one(operator: Page) -> None:
    assert str(BODY_MAX) in refused(operator.post("/api/drawings/plan", content=b" " * (BODY_MAX + 1)), 413)
    for path in ("/api/command", "/api/session"):
        assert str(UNCOUNTED_MAX) in refused(operator.post(path, content=b" " * (UNCOUNTED_MAX + 1)), 413)


@pytest.mark.parametrize("name", NAMES)
def test_names_in_the_address_lead_nowhere_else(name: str, operator: Page) -> None:
    drawing = {"name": "x", "timing": {"kind": "fastest"}, "points": [[0.1, 0.1], [0.2, 0.1]]}
    asked: list[tuple[str, str, Any]] = [
        ("GET", f"/api/recordings/{name}", None),
        ("GET", f"/api/recordings/{name}.rrd", None),
        ("GET", f"/api/recordings/{name}/quick", None),
        ("DELETE", f"/api/recordings/{name}", None),
        ("PUT", f"/api/drawings/{name}", drawing),
        ("GET", f"/api/drawings/{name}.csv", None),
        ("GET", f"/api/layouts/{name}", None),
        ("PUT", f"/api/gains/{name}", None),
        ("GET", f"/api/references/{name}", None),
        ("GET", f"/rerun/{name}", None),
        ("GET", f"/assets/{name}", None),
    ]
    for method, path, body in asked:
        answer = operator.request(method, path, json=body)
        assert answer.status_code in (404, 405, 422), (method, path, answer.status_code)


@pytest.mark.parametrize(("text", "words"), CSV.values(), ids=CSV)
def test_an_imported_file_is_refused_with_its_line_column_and_value(text: bytes, words: str, operator: Page) -> None:
    answer = operator.post("/api/recordings/import?name=x", content=text, headers={"content-type": "text/csv"})
    assert words in refused(answer, 422)
    assert operator.get("/api/recordings").json() == []


@pytest.mark.parametrize("text", GOOD.values(), ids=GOOD)
def test_an_imported_file_may_come_from_any_program(text: bytes, operator: Page) -> None:
    answer = operator.post("/api/recordings/import?name=x", content=text, headers={"content-type": "text/csv"})
    assert (answer.status_code, answer.json().get("rows")) == (200, 2), answer.text


@pytest.mark.parametrize(("text", "words"), TOML.values(), ids=TOML)
def test_an_actuator_file_that_is_none_is_refused_at_once(text: str, words: str, operator: Page) -> None:
    assert words in refused(operator.put("/api/rig/actuator", json={"toml": text}), 422)


@pytest.mark.parametrize("asked", ["from=1e308&to=1e309", "from=-1e308&to=1e308", "from=nan&to=1", "from=&to="])
def test_windows_of_the_history_may_be_anything(asked: str, operator: Page) -> None:
    answer = operator.get(f"/api/history.csv?{asked}&channels=energy")
    assert answer.status_code in (200, 404, 422), answer.text[:200]


def test_ranges_of_a_recording_may_be_anything(operator: Page) -> None:
    text = GOOD["BOM"]
    made = operator.post("/api/recordings/import?name=x", content=text, headers={"content-type": "text/csv"}).json()
    path = f"/api/recordings/{made['id']}.rrd"
    whole = operator.get(path).content
    for asked, status in {
        "bytes=0-9": 206,
        "bytes=-5": 206,
        "bytes=5-2": 400,
        "bytes=99999999999-": 416,
        "bytes=a-b": 400,
        "lines=1-2": 400,
        "bytes=" + "9" * 5000 + "-": 416,
        "bytes=" + ",".join(f"{n}-{n}" for n in range(0, 4000, 2)): 200,  # too many to answer: it is whole
    }.items():
        answer = operator.get(path, headers={"range": asked})
        assert answer.status_code in (status, 400), (asked[:40], answer.status_code)
        assert len(answer.content) < len(whole) + 1_000_000
    assert operator.get(path, headers={"range": "bytes=0-9"}).content == whole[:10]


def test_no_refusal_speaks_in_regular_expressions(operator: Page) -> None:
    for method, path, body in [
        ("PUT", "/api/gains/so%3Fft", None),
        ("PUT", "/api/layouts/a%3Fb", {"seconds": 10, "plots": []}),
        ("PUT", "/api/drawings/.star", {"name": ".star", "points": [[0.0, 0.1], [0.1, 0.1]]}),
        ("PATCH", "/api/recordings/none", {"tags": ["with blanks"]}),
    ]:
        answer = operator.request(method, path, json=body)
        assert answer.status_code == 422, answer.text
        for complaint in answer.json()["detail"]:
            assert "pattern" not in complaint["msg"] and "^" not in complaint["msg"], complaint
            assert complaint["type"] != "string_pattern_mismatch" or "letters" in complaint["msg"]


@pytest.mark.parametrize("path", ["/api/gains/a%2Fb", "/api/layouts/a%2fb", "/api/drawings/a%2Fb"])
def test_a_name_with_a_slash_is_refused_as_such(path: str, operator: Page) -> None:
    refused = operator.request("PUT", path, json={})
    assert (refused.status_code, refused.json()["detail"]) == (404, "no name has a / in it; choose another one")
