"""Measures how long a pressed E-STOP takes until its state is painted, and where the time goes; prints JSON.

Run from the root of the repository: `.venv/bin/python -m tests.e2e.measure_estop`. The product runs with the twin. One
page stays open through all tries: what grows with their number shows as the difference of the first and last quarter.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, expect

from server.app.browser import launch_chromium
from tests.e2e.edge import clear
from tests.e2e.product import Product, open_page

BAR_MS = 150.0
STAGES = ("heard", "answered", "shown", "painted")
"""After the pointer came down: its handler ran, the first way answered, the state is in the page, and on screen."""
MARK = """() => {
  if (window !== window.top) return;
  const marks = (window.__marks = {}), note = (name, at) => { marks[name] ??= at; };
  window.addEventListener("pointerdown", (event) => {
    note("pressed", event.timeStamp);
    note("heard", performance.now());
  }, { capture: true });
  const painted = () => requestAnimationFrame(() => {
    const channel = new MessageChannel();
    channel.port1.onmessage = () => note("painted", performance.now());
    channel.port2.postMessage(0);
  });
  const text = (id) => document.querySelector(`[data-testid=${id}]`)?.textContent ?? "";
  new MutationObserver(() => {
    if (text("stop-news").includes("arrived")) note("answered", performance.now());
    if (marks.pressed === undefined || marks.shown !== undefined || !text("state").includes("E-STOP")) return;
    note("shown", performance.now());
    painted();
  }).observe(document, { subtree: true, childList: true, characterData: true });
}"""


def tries(page: Page, product: Product, count: int) -> list[dict[str, float]]:
    """The stages of each press [ms], from HOLD."""
    found = []
    for _ in range(count):
        page.get_by_test_id("arm").click()
        expect(page.get_by_test_id("state")).to_contain_text("HOLD")
        time.sleep(np.random.default_rng().uniform(0.2, 0.4))  # in step with no beat
        page.evaluate("Object.keys(window.__marks).forEach((name) => delete window.__marks[name])")
        page.get_by_test_id("e-stop").click()
        expect(page.get_by_test_id("stop-news")).to_contain_text("arrived")
        expect(page.get_by_test_id("state")).to_contain_text("E-STOP")
        time.sleep(0.2)
        marks = page.evaluate("window.__marks")
        found.append({name: marks[name] - marks["pressed"] for name in STAGES if name in marks})
        clear(page, product)
    return found


def summary(found: list[dict[str, float]]) -> dict[str, float]:
    """p50 and p95 of every stage, and how the last quarter differs from the first [ms]."""
    figures: dict[str, float] = {}
    for name in STAGES:
        values = [one[name] for one in found if name in one]
        figures |= {f"{name}_p{q}_ms": round(float(np.percentile(values, q)), 1) for q in (50, 95)}
    shown = [one["painted"] for one in found if "painted" in one]
    quarter = max(1, len(shown) // 4)
    figures["growth_ms"] = round(float(np.median(shown[-quarter:]) - np.median(shown[:quarter])), 1)
    return figures


def main() -> None:
    """Measure and print."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--tries", type=int, default=40)
    options = asked.parse_args()
    figures = {}
    with tempfile.TemporaryDirectory() as folder, launch_chromium() as browser, Product(Path(folder)) as product:
        for name, with_3d in (("plan and plots", False), ("with the 3D view", True)):
            context = browser.new_context(viewport={"width": 1280, "height": 720})
            context.add_init_script(f"({MARK})()")
            page = open_page(context, product, with_3d=with_3d)
            page.get_by_test_id("lease-take").click()
            figures[name] = summary(tries(page, product, options.tries))
            page.get_by_test_id("lease-release").click()
            context.close()
    kept = {name: found["painted_p95_ms"] <= BAR_MS for name, found in figures.items()}
    print(json.dumps({"figures": figures, "bar_p95_ms": BAR_MS, "kept": kept}, indent=2))


if __name__ == "__main__":
    main()
