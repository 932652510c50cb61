"""Requests that schemathesis makes from the OpenAPI: no 5xx but documented ones, every answer as it is described."""

import contextlib
import json
import logging
from collections.abc import Iterator
from copy import deepcopy
from functools import cache
from typing import Any

import hypothesis
import jsonschema_rs
import pytest
import schemathesis
from hypothesis.errors import Unsatisfiable
from hypothesis.strategies import SearchStrategy
from schemathesis import GenerationMode
from schemathesis.checks import CHECKS

from server.app.app import openapi_schema
from tests.server.live_server import Page, RigProcess, TestServer, free_environment, wait_for

pytestmark = [pytest.mark.process, pytest.mark.keyed()]

CHECKED = ("not_a_server_error", "status_code_conformance", "content_type_conformance")
DESCRIBED = openapi_schema()
SCHEMA = schemathesis.openapi.from_dict(deepcopy(DESCRIBED))
SCHEMA.config.generation.with_security_parameters = False  # made-up cookies and tokens have `test_doors`
REFUSED = ("401", "403", "404", "409", "411", "413", "421", "422", "429", "503")
OWN = {"/healthz": {"503"}, "/api/command": {"409"}}
"""Refusals with more to say: which part is not well, and the rig's own reply."""
EXPECTED = (503,)
"""The only documented 5xx that a healthy server may give here."""


@pytest.fixture(scope="module")
def operator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """The operator of a rig of its own: what is asked of it here is not for the rig of the other tests."""
    free_environment()
    rig = RigProcess(tmp_path_factory.mktemp("rig"))
    server = TestServer(tmp_path_factory.mktemp("server"), rig.endpoint, rate_factor=1e6)
    yield server.operator()
    server.close()
    rig.stop()


def _operations() -> list[schemathesis.schemas.APIOperation]:
    return [result.ok() for result in SCHEMA.get_all_operations()]


@pytest.mark.parametrize("examples", [2, pytest.param(200, marks=[pytest.mark.long, pytest.mark.timeout(3000)])])
def test_whatever_fits_or_breaks_the_description_is_answered_as_described(
    examples: int, operator: Page, caplog: pytest.LogCaptureFixture
) -> None:
    checks = CHECKS.get_by_names(CHECKED)
    for operation in _operations():
        _try(operation.as_strategy(), operator, examples, checks)
        with contextlib.suppress(Unsatisfiable):  # without parameters nothing can be wrong
            _try(operation.as_strategy(generation_mode=GenerationMode.NEGATIVE), operator, examples, checks)
    assert not [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR]
    wait_for(lambda: operator.get("/api/health").json()["rig_connected"], "the rig")


def _try(cases: SearchStrategy[schemathesis.Case], page: Page, examples: int, checks: list) -> None:
    """So many requests of one operation, always the same ones."""

    @hypothesis.settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate],
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(case=cases)
    def each(case: schemathesis.Case) -> None:
        page.sign_in().post("/api/lease")  # the request before may have signed it out
        cookies = dict(page.cookies)
        response = case.call(base_url=str(page.base_url).rstrip("/"), cookies=cookies, timeout=100)
        if response.status_code not in EXPECTED:
            case.validate_response(response, checks=checks)
        if response.content and response.headers["content-type"] == "application/json":
            told = DESCRIBED["paths"][case.operation.path][case.operation.method.lower()]["responses"]
            schema = _resolved(told[str(response.status_code)])["content"]["application/json"]["schema"]
            _validator(json.dumps(schema)).validate(response.json())

    each()


def _resolved(told: dict[str, Any]) -> dict[str, Any]:
    """What stands there, or in the component it refers to."""
    return DESCRIBED["components"]["responses"][told["$ref"].rsplit("/", 1)[1]] if "$ref" in told else told


@cache
def _validator(schema: str) -> jsonschema_rs.Draft202012Validator:
    """Schemathesis's own check of the body stumbles over pairs (`prefixItems`)."""
    return jsonschema_rs.Draft202012Validator({**json.loads(schema), "components": DESCRIBED["components"]})


def test_every_route_documents_every_refusal_in_one_form() -> None:
    for path, methods in DESCRIBED["paths"].items():
        for method, operation in methods.items():
            told = {status: _resolved(form) for status, form in operation["responses"].items()}
            assert set(REFUSED) <= set(told), (method, path)
            for status in set(REFUSED) - OWN.get(path, set()):
                form = told[status]["content"]["application/json"]["schema"]
                assert form == {"$ref": "#/components/schemas/Problem"}, (method, path, status)
