"""Measures how long a recording of 60 s takes to open in the Review tab, and prints JSON. Needs a quiet machine.

Run from the root of the repository: `.venv/bin/python -m tests.e2e.measure_review`. From the click on its row until all
plots are painted: prepared (as ended recordings are), cold (the server reads the file) and warm (it has the bins), the
median of `--runs`. With
`--rows` more recordings in the list: from the click on the tab of a page just loaded until the list is painted, from
the click on a title until it stands in the new order, and from the last letter of a search that is typed until what it
finds is painted; `--list` measures these alone. `rerun_at_once`: from the click on Signals, as soon as
the quick look stands on a page just loaded, until rerun's viewer shows curves; `rerun`: once it has been read for
`--read` seconds, so that the viewer waits behind it (`rerun_timing.py`).
"""

import argparse
import json
import statistics
import tempfile
from pathlib import Path

from playwright.sync_api import Page, expect

from recordings.format import sidecar
from recordings.format.messages import Recording
from recordings.store.finishing import finish
from server.app.browser import launch_chromium
from tests.e2e.product import Product, open_page, wait_until
from tests.e2e.recorded import list_many, record_circle
from tests.e2e.rerun_timing import Opening, in_rerun

UNTIL_PAINTED = """(start, stands) => new Promise((say) => {
  const look = () => {
    if (!stands()) return requestAnimationFrame(look);
    const channel = new MessageChannel();
    channel.port1.onmessage = () => say((performance.now() - start) / 1e3);
    requestAnimationFrame(() => channel.port2.postMessage(0));
  };
  look();
})"""
"""The message comes once the frame with what was waited for is painted."""
CLICK_UNTIL = f"""([click, sign, count]) => {{
  const start = performance.now();
  document.querySelector(click).click();
  return ({UNTIL_PAINTED})(start, () => document.querySelectorAll(sign).length >= count);
}}"""
TYPE_UNTIL = f"""async ([field, word, between, sign]) => {{
  const input = document.querySelector(field);
  const put = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  let start = 0;
  for (let typed = 1; typed <= word.length; typed += 1) {{
    if (typed > 1) await new Promise((go) => setTimeout(go, between));
    start = performance.now();
    put.call(input, word.slice(0, typed));
    input.dispatchEvent(new Event("input", {{ bubbles: true }}));
  }}
  const rows = () => [...document.querySelectorAll("[data-testid=recording]")];
  return ({UNTIL_PAINTED})(start, () => rows().length === 1 && rows()[0].matches(sign));
}}"""
BETWEEN = 90
"""From one typed letter to the next [ms]: 11 a second."""
PLOTS = ["[data-testid=quick-plot] canvas", 6]


def opened(page: Page, id: str) -> float:
    """Seconds from the click on a row to the painted plots; leaves the list open again."""
    page.get_by_test_id("recording-search").fill(id)
    expect(page.locator(f"[data-id='{id}']")).to_be_visible()
    seconds = float(page.evaluate(CLICK_UNTIL, [f"[data-id='{id}']", *PLOTS]))
    page.get_by_test_id("back").click()
    return seconds


def listed(page: Page, product: Product) -> float:
    """Seconds from the click on the tab, on a page that was just loaded, to the painted list."""
    page.goto(product.origin)  # not a reload, which would open Review by itself
    wait_until(lambda: page.evaluate("!!window.__tendril?.frame"), 20.0)
    return float(page.evaluate(CLICK_UNTIL, ["input[value=review]", "[data-testid=recording]", 50]))


def sorted_in(page: Page) -> float:
    """Seconds until the whole list is in another order."""
    page.get_by_test_id("recording-search").fill("")
    if page.locator("[data-sort='-started']").count() == 0:
        page.get_by_test_id("sort-started").click()
    expect(page.locator("[data-sort='-started']")).to_be_visible()
    return float(page.evaluate(CLICK_UNTIL, ["[data-testid=sort-bytes]", "[data-sort='-bytes']", 1]))


def searched(page: Page, id: str) -> float:
    """Seconds from the last figure typed of the time in `id` until that recording alone is painted."""
    page.get_by_test_id("recording-search").fill("")
    expect(page.get_by_test_id("recording")).to_have_count(50)
    word, sign = id.split("-")[1], f"[data-id='{id}']"
    return float(page.evaluate(TYPE_UNTIL, ["[data-testid=recording-search]", word, BETWEEN, sign]))


def main() -> None:
    """Measure and print."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--runs", type=int, default=5)
    asked.add_argument("--rows", type=int, default=5000)
    asked.add_argument("--read", type=float, default=5.0)
    asked.add_argument("--list", action="store_true")
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as folder, launch_chromium() as browser, Product(Path(folder)) as product:
        first = record_circle(product.recordings, "circle", 60.0)
        finish(product.recordings, first.id)
        like = sidecar.read(product.recordings, first.id)  # with path and figures
        many = [file.stem for file in list_many(product.recordings, like, options.rows)[::2]]
        context = browser.new_context(viewport={"width": 1280, "height": 720})
        page = open_page(context, product)
        figures = of_list(page, product, many, options.runs)
        if not options.list:
            made = [record_circle(product.recordings, f"circle {n}", 60.0) for n in range(2 * options.runs)]
            for recording in made[: options.runs]:  # as the server does with those that it has written
                finish(product.recordings, recording.id)
            figures |= of_openings(page, made, options.runs, options.read)
        context.close()
    print(
        json.dumps({name: {"median": statistics.median(of), "max": max(of)} for name, of in figures.items()}, indent=2)
    )


def of_list(page: Page, product: Product, many: list[str], runs: int) -> dict[str, list[float]]:
    """What is asked of the list that holds `many`."""
    listed(page, product)  # the server reads all descriptions, once
    lists = [listed(page, product) for _ in range(runs)]
    order = [sorted_in(page) for _ in range(runs)]
    return {"list_s": lists, "sort_s": order, "search_s": [searched(page, many[-1 - n]) for n in range(runs)]}


def of_openings(page: Page, made: list[Recording], runs: int, read: float) -> dict[str, list[float]]:
    """What opening one of `made` takes; the first `runs` of them are prepared."""
    prepared = [opened(page, recording.id) for recording in made[:runs]]
    cold = [opened(page, recording.id) for recording in made[runs:]]
    warm = [opened(page, recording.id) for recording in made]
    at_once = [in_rerun(page, recording.id, 0.0) for recording in made[:runs]]
    rerun = [in_rerun(page, recording.id, read) for recording in made[:runs]]
    opening = {"quick_prepared_s": prepared, "quick_cold_s": cold, "quick_warm_s": warm}
    return opening | fields("rerun_at_once", at_once) | fields("rerun", rerun)


def fields(name: str, openings: list[Opening]) -> dict[str, list[float]]:
    """Each field of `openings` as a column."""
    return {f"{name}_{field}": [getattr(one, field) for one in openings] for field in Opening._fields}


if __name__ == "__main__":
    main()
