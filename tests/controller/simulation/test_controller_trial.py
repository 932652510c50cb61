"""Controllers of a package of somebody else, as a rig tries them before it has them."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from controller.assembly.controllers import slot
from controller.assembly.controllers.registry import controllers
from controller.realtime.followable import mistuned
from controller.schema.parameters import RigParameters, Settings
from controller.simulation import controller_trial
from controller.simulation.controller_trial import tried, unfit

pytestmark = pytest.mark.keyed()

HEAD = """
import math
from controller.assembly.controllers.definition import Controller
from controller.kernels.compiled import kernel
"""
LAW = '''
@kernel
def {name}(now, reference, tuning, memory, out_wanted):
    """A test's."""
    {body}

{title} = Controller("{name}", "A test's", {name}, "nowhere")
'''
BODIES = {
    "calm": "out_wanted.u_fb[0] = 0.0",
    "nan": "out_wanted.u_fb[0] = math.nan if now.row > 500 else 0.0",
    "over": "out_wanted.u_ff[1] = 1.0 if not now.led else now.u_ff[1]",
    "slow": "\n    ".join(["for n in range(300_000):", "    memory[n % 8] = math.sin(memory[n % 8] + n)"]),
    "endless": "\n    ".join(["while memory[0] >= 0.0:", "    memory[0] += 1.0 - memory[0]"]),
    "swings": "out_wanted.u_ff[0] = now.u_ff[0] + 0.03 * math.sin(25.0 * memory[0])\n    memory[0] += now.dt",
    "broken": "out_wanted.nothing = 1.0",
}


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Installed, as far as Python looks: a module, and what it offers."""
    laws = [LAW.format(name=name, title=name.upper(), body=body) for name, body in BODIES.items()]
    (tmp_path / "theirs.py").write_text(HEAD + "".join(laws))
    info = tmp_path / "theirs-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: theirs\nVersion: 1.0\n")
    offered = "\n".join(f"{name} = theirs:{name.upper()}" for name in BODIES)
    (info / "entry_points.txt").write_text(f"[tendril.controllers]\n{offered}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setattr(slot, "_COMPILED", {})
    monkeypatch.setattr(slot, "_BROKEN", set())
    controllers.cache_clear()
    yield tmp_path
    controllers.cache_clear()


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("calm", ""),
        ("nan", "E_STOP after 6.[56].* s on the twin: it says what is no number"),
        ("over", r"it asks for [01][.\d]* N m, first after 6.* s, and 0.12 is the most"),
        ("slow", r"a call takes [\d.]+ ms \(99 % of them less\), more than 0.1"),
        ("swings", "REST after .* s on the twin: OSCILLATION"),
    ],
)
def test_what_is_wrong_with_a_controller_is_said_with_its_figure(package: Path, name: str, complaint: str) -> None:
    assert re.fullmatch(complaint, tried(RigParameters(), name)), tried(RigParameters(), name)


@pytest.mark.process
def test_one_that_does_not_end_or_cannot_be_compiled_is_refused_and_the_others_are_there(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(controller_trial, "PATIENCE_S", 30.0)
    found = {name: unfit(RigParameters(), name) for name in ("calm", "endless", "broken")}
    assert found["calm"] == "" and found["endless"] == "it did not come to the end of a trial of 10 s"
    assert found["broken"].startswith("it is not one: ")
    infos = tuple(one.info(found.get(one.name, "")) for one in controllers())
    names = [one.name for one in infos]
    endless, calm = (Settings(controller=names.index(name)) for name in ("endless", "calm"))
    assert mistuned(endless, infos) == f"refused: controller endless: {found['endless']}"
    assert mistuned(calm, infos) == mistuned(Settings(), infos) == ""
    laws = slot.build_slot(1).laws
    assert laws[names.index("broken")] == laws[0], "nobody's code is called in its place"
    assert len(np.unique(laws)) == len(laws) - 1
