"""Every kernel into the cache, on two processes: the first time one alone would take more than a minute.

The code of a kernel holds that of all it calls, except through a pointer (`controller/kernels/function_pointer.py`): so
what is called comes in an earlier round. The two parts of a round share next to nothing. A part calls its kernels
once, with arguments of the types that the tick gives them.
"""

import os
import re
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from controller import compiled_sources
from controller.arrays import Record
from controller.system.progress import say
from controller.system.work_process import WorkProcess

if TYPE_CHECKING:
    from controller.schema.parameters import PlantKind

DECLARED = re.compile(r"^@(?:kernel|inlined|compiled|njit\(cache=True)", re.MULTILINE)
POLL_S = 0.2
"""From one look at what has been compiled to the next [s]."""


def compile_kernels(out: Console) -> None:
    """Compile what is not in the cache yet, and show on `out` how far that is."""
    columns = TextColumn("Compiling kernels"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    say(out, "Compiling kernels: a minute or two where none is kept")
    both = [WorkProcess("compiling", patience=None) for _ in range(2)]
    with ThreadPoolExecutor(2) as threads, ExitStack() as ends, Progress(*columns, console=out) as progress:
        for process in both:
            ends.callback(process.stop)
        bar = progress.add_task("", total=declared())
        for parts in ROUNDS:
            asked = {threads.submit(who.call, part) for who, part in zip(both, parts, strict=False)}
            while asked:
                done, asked = wait(asked, POLL_S)
                progress.update(bar, completed=kept())
                for answer in done:
                    answer.result()


def declared() -> int:
    """Kernels that rig and server call; those of research are compiled when it calls them."""
    return sum(len(DECLARED.findall(text)) for text in _declaring().values())


def kept() -> int:
    """Those of them that are in the cache: numba has an index for each, in a folder for each folder of sources.

    Another clone of the same sources has folders of its own beside ours.
    """
    folders = {_folder_of(path) for path in _declaring()}
    cache = Path(os.environ["NUMBA_CACHE_DIR"])
    return sum(1 for folder in folders for _ in cache.glob(f"**/{folder}/*.nbi"))


def _folder_of(source: Path) -> str:
    from controller.numba_internals import caching

    named: Any = caching._CacheLocator
    return str(named.get_suitable_cache_subpath(str(source)))


def _declaring() -> dict[Path, str]:
    """Sources, with their text, that declare such kernels."""
    texts = {path: path.read_text() for path in compiled_sources() if "research" not in path.parts}
    return {path: text for path, text in texts.items() if DECLARED.search(text)}


def model() -> None:
    """The rod, both integrators, the observer's step, the static map and its poses under gravity."""
    from controller.assembly.rig import build_rig
    from controller.schema.parameters import RigParameters

    hanging = RigParameters().actuator.model_copy(update={"gravity": (9.81, 0.0)})
    build_rig(RigParameters(actuator=hanging), boot=1)


def plant() -> None:
    """Both plants, and the last stage before real valves."""
    from controller.assembly.cosserat import build_cosserat
    from controller.assembly.plant import build_hardware
    from controller.assembly.twin import build_twin
    from controller.kernels.plant.cosserat import cosserat_step
    from controller.kernels.plant.hardware import hardware_step
    from controller.kernels.plant.twin import twin_step
    from controller.schema.hardware import Valves
    from controller.schema.parameters import RigParameters

    _, measurement, _, telemetry = _records()
    twin_step(1, build_twin(RigParameters()), telemetry, measurement)
    cosserat_step(1, build_cosserat(RigParameters()), telemetry, measurement)
    hardware_step(1, build_hardware(Valves(driver="serial"), 1e-3), telemetry, measurement)


def estimate() -> None:
    """The stages of the tick up to the observer."""
    from controller.kernels.control.report import report_estimate
    from controller.kernels.control.timing import begin_tick
    from controller.kernels.observer.observer import observe
    from controller.kernels.observer.sensing import sense

    given = _given()
    control, observer, sensing = given.rig.control, given.rig.observer, given.rig.sensing
    settings = given.command["settings"]
    begin_tick(1, control)
    sense(observer, 1, settings, given.measurement, control, sensing)
    observe(1, settings, given.measurement, 1, sensing, control, observer)
    report_estimate(control, sensing, 1, given.measurement, observer, given.telemetry)


def command() -> None:
    """The stages of the tick from the safety states on."""
    from controller.kernels.control.begin import begin
    from controller.kernels.control.feedback import feed_back, saturate
    from controller.kernels.control.feedforward import feed_forward
    from controller.kernels.control.follow import refer
    from controller.kernels.control.report import report_command, report_loop
    from controller.kernels.control.timing import feedforward_due
    from controller.kernels.safety.safety import supervise

    given = _given()
    control, settings = given.rig.control, given.command["settings"]
    supervise(1, given.command, given.status, given.measurement, given.rig.observer.u_hat, control)
    begin(settings, given.telemetry, given.rig.sensing, control)
    feedforward_due(control, settings)
    refer(given.command, True, control)
    feed_forward(settings, True, control)
    feed_back(settings, control, given.telemetry)
    saturate(control, given.telemetry)
    report_command(control, given.command, given.telemetry)
    report_loop(1, given.command, given.status, control, given.telemetry)


def whole_tick() -> None:
    """The tick of its stages."""
    from controller.kernels.control.tick import tick

    given = _given()
    tick(1, given.command, given.measurement, given.status, given.rig, given.telemetry)


def beside() -> None:
    """What neither tick nor loop calls: the replay of recordings, the velocity that the implicit step leaves open, the
    inverse of one point alone, what a pose is out of balance by, a first mode, and the loop of a virtual rig.
    """
    from controller.assembly.plant import build_plant
    from controller.kernels.control.inverse import invert
    from controller.kernels.model.equilibrium import out_of_balance
    from controller.kernels.model.implicit import meet_hinges
    from controller.kernels.observer.observer import Replay
    from controller.kernels.observer.replay import RecordedSamples, replay
    from controller.reference.torques import planned_torques
    from controller.schema.parameters import RigParameters
    from controller.simulation.first_mode import mode_response
    from controller.virtual.plant import compile_plant

    control, observer = _given().rig.control, _given().rig.observer
    nothing = np.zeros((1, 1, 2))
    invert(control.smap, (0.0, 0.0), (0.0, 0.0), True, control.scratch)
    model, state, work = observer.model, observer.state, observer.implicit_work
    meet_hinges(model, state.q, state.v, work)
    run = Replay(model, state, observer.load, work, observer.sensors, model.rest, np.ones(2), 1e-3)
    samples = RecordedSamples(nothing, nothing, np.ones(1, np.int64), 0.05)
    replay(0, samples, run, np.zeros((1, observer.points.shape[0], 2)))
    out_of_balance(control.smap.statics.body, 0.0, 0.0, control.scratch)
    mode_response(np.zeros(2), 1.0, 0.1, 0.0, 1e-3)
    parameters = RigParameters()
    planned_torques(parameters.actuator, parameters.controller, np.tile([0.25, 0.01], (2, 1)), np.zeros((2, 2)))
    compile_plant(build_plant(RigParameters()), raw=False)


def with_rod() -> None:
    """The loop of the rig with the twin, the loop without a clock, and all else that a preview calls.

    Hardware compiles a few seconds more when it is first asked for.
    """
    _with_plant("rod")


def with_cosserat() -> None:
    """The same with the other plant."""
    _with_plant("cosserat")
    beside()


def _with_plant(plant: "PlantKind") -> None:
    from controller.assembly.plant import build_plant
    from controller.assembly.rig import build_rig
    from controller.realtime.loop import compile_loop
    from controller.schema.parameters import RigParameters, TwinParameters
    from server.runs.preview import warm_up

    parameters = RigParameters(twin=TwinParameters(plant=plant))
    compile_loop(build_rig(parameters, boot=1), build_plant(parameters))
    warm_up(parameters)


ROUNDS = ((model,), (estimate, command), (whole_tick, plant), (with_rod, with_cosserat))


class Given(NamedTuple):
    """What a tick is given: records, and a rig."""

    command: Record
    measurement: Record
    status: Record
    telemetry: Record
    rig: Any


def _given() -> Given:
    from controller.assembly.rig import build_rig
    from controller.schema.parameters import RigParameters

    return Given(*_records(), build_rig(RigParameters(), boot=1))


def _records() -> tuple[Record, Record, Record, Record]:
    from controller.schema.layout import record_dtype
    from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry

    command, measurement, status, telemetry = (
        np.zeros(1, record_dtype(kind))[0] for kind in (Command, Measurement, LoopStatus, Telemetry)
    )
    return command, measurement, status, telemetry
