"""`tendril bench`: the kernels' times beside other engines', and the live loop with the whole product on it."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from controller.errors import TendrilError
from controller.link import RigClient
from controller.realtime.settings import RigSettings
from controller.research.bench.bench import bench
from controller.research.bench.loop_bench import bench_rig, measure_loop
from controller.research.bench.mujoco_chain import lacks_mujoco
from controller.system.keys import read_key
from controller.system.origin import install_command
from controller.system.progress import ProgressCallback, no_progress, progress
from server.app.browser import launch_chromium, require_browser
from server.app.up import ServerChild
from server.settings import ServerSettings

Figures = dict[str, Any]
SECONDS, QUICK_SECONDS = 60.0, 5.0
"""How long the live loop runs [s]."""


def run_bench(quick: bool, out: Console) -> Figures:
    """All figures of `tendril bench --json`; the live loop runs with page, 3D view and recording on.

    What cannot be measured here is said before the work, and is null in the figures.
    """
    for lack in filter(None, (lacks_browser(), lacks_mujoco())):
        out.print(f"left out: {lack}", markup=False, highlight=False, soft_wrap=True)
    seconds = QUICK_SECONDS if quick else SECONDS
    with progress(out, f"Running the loop for {seconds:.0f} s with page, 3D view and recording") as told:
        live = measure_live(seconds, told)
    with progress(out, "Timing the kernels") as told:
        figures = bench(quick, told) | live
    out.print(_table(figures))
    return figures


def lacks_browser() -> str:
    """Why no page can be open on the loop that is measured, and how to change that; "" if one can."""
    try:
        require_browser()
    except TendrilError as error:
        return str(error)
    return ""


def measure_live(seconds: float, told: ProgressCallback = no_progress) -> Figures:
    """Loop figures, what the recorder wrote meanwhile, and which page was open: "chromium", or "none" without one."""
    with tempfile.TemporaryDirectory(prefix="tendril-bench-") as name, _product(Path(name)) as (client, url):
        origin, token = url.split("/?token=")
        with _page(url) as page, httpx.Client(base_url=origin, headers={"Origin": origin}, timeout=30.0) as http:
            _ask(http, "POST", "/api/session", {"token": token})
            _ask(http, "POST", "/api/lease")
            _ask(http, "POST", "/api/recordings", {"name": "bench"})
            loop = measure_loop(client, seconds, told=told)
            _ask(http, "POST", "/api/lease")  # it has lapsed: no page of ours kept it
            recorded = _ask(http, "DELETE", "/api/recordings/current")
        return {"loop": loop, "recording": {"rows": recorded["rows"], "gaps": recorded["gaps"]}, "page": page}


@contextmanager
def _page(url: str) -> Iterator[str]:
    """The page in a browser; where there is none the loop is measured without, and the figures say so."""
    if lacks_browser():
        yield "none"
        return
    with launch_chromium() as browser:
        page = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
        page.goto(url)
        page.get_by_role("button", name="E-STOP").wait_for(timeout=60_000)
        page.wait_for_timeout(3000)  # the 3D view and the first history are start-up, not the loop's daily load
        yield "chromium"


@contextmanager
def _product(folder: Path) -> Iterator[tuple[RigClient, str]]:
    """A rig with the bare thread beside its loop, a server on it, and the address of the page."""
    name = f"bench-{os.getpid()}"
    settings = ServerSettings(rig=name, port=0, state=folder, recordings=folder / "recordings")
    with bench_rig(RigSettings(rig=name, key_file=settings.key)) as rig:
        settings = settings.model_copy(update={"endpoint": rig.endpoint})
        child = ServerChild(settings, folder / "server.json")
        client = RigClient(rig.endpoint, rig.settings.rig, lambda rows: None, key=read_key(settings.key))
        try:
            yield client, child.wait_ready().url
        finally:
            client.close()
            child.stop()


def _ask(http: httpx.Client, method: str, path: str, body: Figures | None = None) -> Figures:
    answer = http.request(method, path, json=body)
    if not answer.is_success:
        raise TendrilError(f"{path} was answered with {answer.status_code}: {answer.text}")
    return answer.json()  # type: ignore[no-any-return]


def _table(figures: Figures) -> Table:
    table = Table("figure", "value", title="tendril bench", title_justify="left")
    for name, value in (*_kernel_rows(figures), *_loop_rows(figures), *_scaling_rows(figures)):
        table.add_row(name, value)
    return table


def _kernel_rows(figures: Figures) -> Iterator[tuple[str, str]]:
    yield "RK4 rod step, N = 10", f"{figures['rod_step_us']:.2f} us"
    if figures["mujoco_step_us"] is not None:
        yield "MuJoCo, same chain", f"{figures['mujoco_step_us']:.2f} us (ratio {figures['rk4_over_mujoco']:.3f})"
        yield "tips apart over 2 s, at most", f"{figures['mujoco_tip_difference_m']:.1e} m"
    yield "PyElastica over ours, same rod, per simulated second", _elastica(figures)
    yield "controller tick, N = 10; 1000 rods, implicit", f"{figures['tick_us']:.1f}; {figures['tick_n1000_us']:.0f} us"
    yield "batch of 10 rows: proven by the rig; judged by the server", _proofs(figures)
    closed, speed = figures["closed_loop_seconds"], figures["closed_loop_seconds_per_second"]
    yield "closed loop with twin on one core", f"{closed:.0f} s in {closed / speed:.1f} s ({speed:.0f} s/s)"
    fits = figures["ensemble"]
    simulated, ratio = fits["seconds_per_second"], fits["implicit_over_rk4"]
    yield "the same as calibrations run it, per core", f"{simulated:.0f} s/s ({ratio:.2f} times the usual twin)"


def _proofs(figures: Figures) -> str:
    return f"{figures['link']['prove_us']:.0f}; {figures['link']['judge_us']:.0f} us, 60 times a second"


def _elastica(figures: Figures) -> str:
    if (found := figures["elastica"]) is None:
        return escape(f"PyElastica is not installed: {install_command('engines')}")
    apart, rest = 1e3 * found["tip_difference_m"], 1e3 * found["tip_difference_at_rest_m"]
    return f"{found['elastica_over_ours']:.0f} (tips {apart:.1f} mm apart at most, {rest:.1f} mm at rest)"


def _loop_rows(figures: Figures) -> Iterator[tuple[str, str]]:
    loop, lateness = figures["loop"], figures["loop"]["lateness_us"]
    yield f"loop, {loop['policy']}", f"{loop['ticks']} ticks in {loop['seconds']:.0f} s"
    yield "lost ticks; a bare thread lost", f"{loop['lost']}; {loop['baseline_lost']}"
    late = ", ".join(f"{name} {lateness[name]:.0f}" for name in ("p50", "p99", "p999", "max"))
    yield "wake-up lateness", f"{late} us"
    yield "recorded rows, gaps", f"{figures['recording']['rows']}, {figures['recording']['gaps']}"


def _scaling_rows(figures: Figures) -> Iterator[tuple[str, str]]:
    for row in figures["scaling"]:
        dense = "-" if row["dense_step_us"] is None else f"{row['dense_step_us']:.0f} us"
        yield f"{row['integrator']} step, N = {row['n']}; dense", f"{row['step_us']:.2f} us; {dense}"
    ratios = (f"{figures[f'{part}_n1000_over_n10']:.0f}" for part in ("rk4", "implicit", "tick"))
    yield "N = 1000 over N = 10: RK4 step, implicit step, tick", ", ".join(ratios)
