"""What works on data, models and simulations and needs no rig, from `identify` to `reproduce`."""

from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console

from controller.system.origin import command_line
from server.cli.research.benchmark import app as benchmark_app
from server.cli.typed import Comments, ObserverKappa, TwinNumbers, commands, controller_of, refuse_given

app = commands()
app.add_typer(benchmark_app, name="benchmark")
out = Console()

PlantName = Annotated[
    Literal["rod", "cosserat"], typer.Option(help="Simulated plant: rigid rods as in the model, or a Cosserat rod.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers do the work (`tendril docs calibration`)."),
]
ControllerName = Annotated[
    str, typer.Option(help="What is in the slot: paper, letter, preview, adaptive (`tendril docs control`).")
]
PAPERS_OWN = ("ff", "ff+p", "ff+i", "paper")
"""Laws whose feedforward is the paper's."""
ActuatorName = Annotated[str, typer.Option(help="P1, P2, P3 or a .toml file (`tendril docs actuators`).")]


@app.command()
def identify(
    data: Annotated[list[Path], typer.Argument(help="CSV files of one actuator: a static test, free decays, or both.")],
    out_file: Annotated[Path, typer.Option("--out", help="Actuator file (.toml) to write.")],
    ids: Annotated[str | None, typer.Option(help="Free decays to use, as in 0-16,20; all without it.")] = None,
    actuator: Annotated[str, typer.Option(help="Says what the data do not: P1, P2, P3 or a .toml file.")] = "P1",
    report: Annotated[Path | None, typer.Option(help="HTML page with plots and residuals to write.")] = None,
    profile: Annotated[str, typer.Option(help="Stiffness: uniform, linear, scaled, or auto as in the base.")] = "auto",
    robust: Annotated[bool, typer.Option(help="Weigh down static values that lie far out.")] = False,
    zeta: Annotated[
        float | None, typer.Option(min=1e-3, max=1.0, help="Damping ratio of the first mode, where no decays tell it.")
    ] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
) -> None:
    """Fit stiffness and damping to measured data (`tendril docs identification`)."""
    from controller.research.identification.identify import IdentificationTask
    from controller.schema.actuator import read_actuator
    from server.cli.research.identify import run_identify

    task = IdentificationTask(tuple(data), read_actuator(actuator), ids, profile, robust, zeta, command_line())
    run_identify(task, out_file, report, json_file, out)


@app.command()
def observe(
    data: Annotated[Path, typer.Argument(help="CSV file of free decays.")],
    actuator: Annotated[str, typer.Option(help="Actuator file that tendril identify wrote from free decays.")],
    sense: Annotated[str, typer.Option(help="Bodies that the observer is given, as in 2,3.")],
    score: Annotated[str, typer.Option(help="Bodies whose estimates are scored, as in 1,2.")],
    ids: Annotated[str | None, typer.Option(help="Decays to observe, as in 18-34; all without it.")] = None,
    from_s: Annotated[float, typer.Option("--from", help="Score from here on, too [s].")] = 0.3,
    rods: Annotated[
        int | None, typer.Option(min=2, max=1000, help="Of the model; as the file says without it.")
    ] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
    rrd: Annotated[Path | None, typer.Option(help="Write a recording for rerun to this file.")] = None,
) -> None:
    """Run the observer over recorded decays and score bodies that it does not see (`tendril docs identification`)."""
    from controller.research.identification.observe import ObserverTask
    from controller.schema.actuator import read_actuator
    from server.cli.research.observe import numbers, run_observe

    bodies = numbers("sense", sense), numbers("score", score)
    run_observe(ObserverTask(data, read_actuator(actuator), *bodies, ids, from_s, rods), json_file, rrd, out)


@app.command()
def validate(
    data: Annotated[Path, typer.Argument(help="CSV file of free decays of several bodies.")],
    sense: Annotated[str, typer.Option(help="Bodies that the observer is given, as in 2,3.")],
    score: Annotated[str, typer.Option(help="Bodies whose estimates are scored, as in 1,2.")],
    ids: Annotated[str | None, typer.Option(help="Decays to use, as in 0-16; all without it.")] = None,
    actuator: Annotated[str, typer.Option(help="Says what the data do not: P1, P2, P3 or a .toml file.")] = "P1",
    from_s: Annotated[float, typer.Option("--from", help="Score from here on, too [s].")] = 0.3,
    rate: Annotated[
        float | None, typer.Option(help="Of the observer's springs [rad/s]; the usual one if none.")
    ] = None,
    every: Annotated[bool, typer.Option(help="Every stiffness profile, not only what is identified.")] = False,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
) -> None:
    """Leave each decay out, identify from the others, and score what the observer says of it."""
    from controller.schema.actuator import read_actuator
    from server.cli.research.observe import numbers
    from server.cli.research.validate import ValidationTask, run_validate

    bodies = numbers("sense", sense), numbers("score", score)
    run_validate(ValidationTask(data, read_actuator(actuator), *bodies, ids, from_s, rate, every), json_file, out)


@app.command()
def calibrate(
    out_file: Annotated[Path | None, typer.Option("--out", help="TOML file to write; only shown without it.")] = None,
    starts: Annotated[
        int | None,
        typer.Option(min=1, max=100, help="Points that are polished, the best first.", show_default="2; --quick: 1"),
    ] = None,
    screen: Annotated[
        int | None,
        typer.Option(min=1, max=100_000, help="Points that are tried first.", show_default="100; --quick: 8"),
    ] = None,
    minutes: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            max=10_000.0,
            help="For the search; near-equal fits get as much again.",
            show_default="30; --quick: 1",
        ),
    ] = None,
    generations: Annotated[
        int | None,
        typer.Option(min=0, max=10_000, help="Of the evolution after the starts.", show_default="60; --quick: 0"),
    ] = None,
    rounds: Annotated[
        int | None,
        typer.Option(min=0, max=10_000, help="Moves of every near-equal fit.", show_default="40; --quick: 1"),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="Of the points and of the twin's noise.")] = 0,
    workers: Annotated[int | None, typer.Option(min=1, max=256, help="Processes; one a core without it.")] = None,
    scheduler: Scheduler = None,
    quick: Annotated[
        bool, typer.Option(help="A look at whether it runs: few points, no margins, no good fit.")
    ] = False,
    plant: PlantName = "rod",
) -> None:
    """Fit the twin's unknowns and the gains to the paper's fit rows (`tendril docs calibration`)."""
    from controller.research.calibration.calibrate import CalibrationTask
    from controller.research.calibration.margins import TRIALS
    from controller.research.calibration.problem import Problem
    from controller.research.calibration.search import QUICK, Effort, effort_of
    from controller.research.calibration.space import space_of
    from server.cli.research.calibrate import run_calibrate

    effort = effort_of(
        QUICK if quick else Effort(),
        screen=screen,
        starts=starts,
        minutes=minutes,
        generations=generations,
        rounds=rounds,
    )
    problem = Problem(space_of(plant), trials=() if quick else TRIALS, seed=seed)
    run_calibrate(CalibrationTask(problem, effort, seed, workers, scheduler, command_line()), out_file, out)


@app.command()
def reach(
    context: typer.Context,
    actuator: Annotated[str, typer.Argument(help="P1, P2, P3 or a .toml file (`tendril docs actuators`).")],
    rods: Annotated[int, typer.Option(min=2, max=1000, help="Of the model.")] = 10,
    csv: Annotated[Path | None, typer.Option(help="Write the torques and tips of a grid to this file.")] = None,
    svg: Annotated[Path | None, typer.Option(help="Write a drawing of the reach to this file.")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
    comments: Comments = False,
) -> None:
    """How far the tip reaches: the image of all admissible torques, at rest (`tendril docs actuators`)."""
    from controller.schema.actuator import read_actuator
    from controller.schema.parameters import ControllerParameters, RigParameters
    from server.cli.research.reach import Files, run_reach

    if csv is None:
        refuse_given(context, "is for the file of --csv", "comments")
    parameters = RigParameters(actuator=read_actuator(actuator), controller=ControllerParameters(rods=rods))
    run_reach(parameters, Files(csv, svg, json_file), comments, out)


@app.command()
def statics(
    actuator: ActuatorName = "P1",
    rods: Annotated[int, typer.Option(min=2, max=1000, help="Of the model.")] = 10,
    u: Annotated[str, typer.Option("--u", help="Torques u_1,u_2 of the chamber pairs [N m].")] = "0,0",
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
) -> None:
    """Where the arm comes to rest under torques, gravity and tip load (`tendril docs actuators`)."""
    from controller.schema.actuator import read_actuator
    from controller.schema.parameters import ControllerParameters, RigParameters
    from server.cli.research.statics import run_statics

    parameters = RigParameters(actuator=read_actuator(actuator), controller=ControllerParameters(rods=rods))
    run_statics(parameters, u, json_file, out)


@app.command()
def stability(
    actuator: ActuatorName = "P1",
    rods: Annotated[int, typer.Option(min=2, max=1000, help="Of the model.")] = 10,
    sense: Annotated[str, typer.Option(help="Sensors that the observer is given, 1 to 10, as in 6,10.")] = "10",
    k_o: Annotated[float, typer.Option("--k-o", help="Stiffness of the virtual springs [N/m].")] = 400.0,
    b_o: Annotated[float, typer.Option("--b-o", help="Damping of the virtual springs [N s/m].")] = 0.5,
    integrator: Annotated[
        Literal["rk4", "implicit"], typer.Option(help="The observer's step, as of `tendril up`.")
    ] = "implicit",
    zeta: Annotated[float | None, typer.Option(help="The arm's damping ratio, where it is known.")] = None,
    kappa: Annotated[
        float | None, typer.Option(help="Factor on stiffness and torque, which its first mode's square shows.")
    ] = None,
    rig: Annotated[str | None, typer.Option(help="Take both as they were measured on this rig.")] = None,
    observer_kappa: ObserverKappa = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
) -> None:
    """Whether the observer, and the loop around it, are stable over the whole reach (`tendril docs observer`)."""
    from controller.schema.actuator import read_actuator
    from controller.schema.parameters import RigParameters
    from server.cli.research.stability import Wanted, run_stability

    body = read_actuator(actuator)
    parameters = RigParameters(actuator=body, controller=controller_of(body, observer_kappa, rods, integrator))
    run_stability(parameters, Wanted(sense, k_o, b_o, zeta, kappa, rig), json_file, out)


@app.command()
def track(
    context: typer.Context,
    reference: Annotated[Path, typer.Option(help="CSV file with columns t, x, y [s, m] (`tendril docs tables`).")],
    actuator: ActuatorName = "P1",
    law: Annotated[
        str, typer.Option(help="ff, ff+p, ff+i, ff+pi; paper: to its letter; sensors of ff+pi: rod6, rod10, rod6+10.")
    ] = "ff+pi",
    controller: Annotated[
        str | None,
        typer.Option(help="What is in the slot (`tendril docs control`): without it preview, or paper for its laws."),
    ] = None,
    tune: Annotated[str, typer.Option(help="Numbers of the controller, as in K_P=0.3,lag=0.1.")] = "",
    plant: PlantName = "rod",
    plant_actuator: Annotated[
        str | None, typer.Option(help="What is simulated, where it is another body than the model's --actuator.")
    ] = None,
    twin: TwinNumbers = "",
    observer_kappa: ObserverKappa = None,
    plant_scale: Annotated[
        str, typer.Option(help="Another plant: factors k, b, torque, friction, noise; added seconds delay, latency.")
    ] = "",
    velocity_feedforward: Annotated[
        bool | None, typer.Option(help="K_FF; without it on if the path repeats and does not jump.")
    ] = None,
    frequency: Annotated[float | None, typer.Option(help="Of the path [Hz]; found without it if it repeats.")] = None,
    start: Annotated[
        float | None, typer.Option(help="When the shape begins [s after the first row]; found without it.")
    ] = None,
    project: Annotated[bool, typer.Option(help="Follow the nearest points where the path is out of reach.")] = False,
    learn: Annotated[int, typer.Option(min=0, max=100, help="Repeats from which it is learned before the run.")] = 0,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 101, help="Of the twin's noise; a repeat has the next.")] = 0,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
    out_file: Annotated[
        Path | None, typer.Option("--out", help="Write every tick to this file: .csv, .parquet or .rrd.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw path, tip and error into this file: .svg or .pdf.")] = None,
    comments: Comments = False,
) -> None:
    """Follow any path on the twin and measure it like the paper's experiments (`tendril docs tracking`)."""
    from controller.assembly.controllers.registry import with_controller
    from controller.reference.drawn import Wish
    from controller.research.experiments.plant_scale import scaled
    from controller.research.track import TrackTask
    from controller.schema.actuator import read_actuator
    from controller.schema.parameters import REPEATING, usual_twin
    from controller.schema.twin_numbers import inline, twin_numbers
    from controller.simulation.case import Setup
    from server.cli.research.track import Wanted, run_track

    controller = controller or ("paper" if law in PAPERS_OWN else "preview")
    gains = with_controller(REPEATING, controller, inline("tune", tune, "K_P=0.3,lag=0.1"))
    if out_file is None or out_file.suffix != ".csv":
        refuse_given(context, f"is for --out FILE.csv, not {out_file or 'a run without --out'}", "comments")
    wish = Wish(project, frequency, velocity_feedforward, start)
    model, body = read_actuator(actuator), read_actuator(plant_actuator) if plant_actuator else None
    observing = controller_of(model, observer_kappa)
    simulated = usual_twin(body or model, twin_numbers(twin, plant=plant))
    setup = Setup(scaled(simulated, plant_scale, body or model), observing, gains)
    task = TrackTask(reference, model, law, seed, wish, setup, body, learn)
    run_track(task, Wanted(json_file, out_file, plot, comments), out)


@app.command()
def reproduce(
    report: Annotated[Path | None, typer.Option(help="Folder for the report and a recording of each case.")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write all rows to this file.")] = None,
    quick: Annotated[bool, typer.Option(help="Run every case once instead of 3 times (Task 4: 5).")] = False,
    controller: ControllerName = "letter",
    law: Annotated[
        Literal["ours", "paper"], typer.Option(help="paper: its equations to the letter as well, beside ours.")
    ] = "ours",
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 6, help="Of the first run; the next ones count on.")] = 0,
    workers: Annotated[int | None, typer.Option(min=1, max=256, help="Processes; one a core without it.")] = None,
    plant: PlantName = "rod",
) -> None:
    """Run every experiment of the paper on the twin and compare (`tendril docs reproduction`)."""
    from dataclasses import replace

    from controller.assembly.controllers.registry import with_controller
    from controller.research.experiments.catalogue import catalogue
    from controller.research.experiments.fitted_intervals import paper_setup
    from controller.research.experiments.pool import cores
    from controller.research.experiments.reproduce import Reproduction
    from server.cli.research.reproduce import run_reproduce

    setup = paper_setup(plant)
    setup = replace(setup, gains=with_controller(setup.gains, controller))
    order = Reproduction(catalogue(seed, quick), setup, workers or cores(), quick, letter=law == "paper")
    run_reproduce(order, report, json_file, out)
