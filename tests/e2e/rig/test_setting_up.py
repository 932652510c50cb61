"""What an operator sets up: sensors and faults of the twin, gains, the actuator; and a recording looked at in 3D."""

import re
from datetime import UTC, datetime
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from controller.schema.actuator import PRESETS, write_actuator
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters
from server.hardware.first_mode.messages import Interval, KeptMode, MeasuredMode
from server.hardware.first_mode.store import FirstModes, modes_file
from tests.e2e.hand import arm, begin_circle
from tests.e2e.product import Product, frame, shot, wait_until

pytestmark = pytest.mark.keyed(
    "frontend/src", "server/hardware", "server/health", "server/operate", "tests/e2e/*.py", imports=False
)

TUNING = "fetch('/api/settings').then((answer) => answer.json()).then(({ tuning }) => tuning)"
"""What the rig has."""
DASH = "\u2013"
"""What stands for a missing value."""
NOTE_WORDS = """() => {
  const said = (window.__said = { banner: [], "actuator-status": [] }), note = () => {
    for (const [place, texts] of Object.entries(said)) {
      const text = document.querySelector(`[data-testid=${place}]`)?.textContent ?? "";
      if (text && !texts.includes(text)) texts.push(text);
    }
  };
  new MutationObserver(note).observe(document.body, { subtree: true, childList: true, characterData: true });
}"""
"""Keeps all that banner and status say from now on: who asks a page once a second may miss one."""


def number(page: Page, test_id: str) -> float:
    """The number that a live text shows; nan for a dash."""
    text = page.get_by_test_id(test_id).inner_text().split(" ")[0]
    return float("nan") if text in ("", DASH) else float(text)


def operate(page: Page, tab: str) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_role("tab", name=tab).click()


def test_a_marker_is_lost_and_the_unsensed_rods_show_what_the_observer_misses(page: Page) -> None:
    operate(page, "Sensing")
    page.get_by_test_id("preset-6+10").click()
    wait_until(lambda: number(page, "residual-6") >= 0 and number(page, "miss-3") >= 0)
    assert page.get_by_test_id("residual-3").inner_text() == DASH
    page.get_by_test_id("fault-rods").select_option("rod 6")
    page.get_by_test_id("fault-marker_loss").fill("100")
    page.get_by_test_id("fault-marker_loss").press("Enter")
    wait_until(lambda: page.get_by_test_id("residual-6").inner_text() == DASH)
    assert number(page, "residual-10") >= 0
    shot(page, "sensing-faults")
    page.get_by_test_id("faults-off").click()
    wait_until(lambda: number(page, "residual-6") >= 0)
    page.get_by_test_id("preset-tip").click()
    page.get_by_test_id("lease-release").click()


def test_gains_are_saved_changed_and_loaded_again(page: Page) -> None:
    operate(page, "Gains")
    field = page.get_by_test_id("K_o-x")
    field.fill("150")
    field.press("Enter")
    page.get_by_test_id("gain-presets").click()
    page.get_by_test_id("gain-preset-name").fill("stiff observer")
    page.get_by_test_id("gain-preset-save").click()
    expect(page.get_by_test_id("gain-preset")).to_have_text(["Paths that repeat", "stiff observer"])
    shot(page, "gain-presets")
    page.keyboard.press("Escape")
    page.get_by_test_id("gains-reset").click()
    expect(field).to_have_value("400")
    page.get_by_test_id("gain-presets").click()
    page.get_by_test_id("gain-preset").last.click()
    expect(field).to_have_value("150")
    page.get_by_test_id("gain-presets").click()
    page.get_by_test_id("gain-preset").first.click()
    expect(page.get_by_test_id("K_FF-x")).to_have_count(0)  # which counts with the paper's controller alone
    page.get_by_test_id("controller").select_option("paper")
    expect(page.get_by_test_id("K_FF-x")).not_to_have_value("0")
    page.get_by_test_id("gains-reset").click()
    page.get_by_test_id("controller").select_option("preview")
    expect(page.get_by_test_id("tuning-K_I")).to_be_visible()
    page.get_by_test_id("lease-release").click()


def test_preview_is_put_into_the_slot_tuned_and_runs_a_circle(page: Page) -> None:
    arm(page)
    page.get_by_role("tab", name="Gains").click()
    expect(page.get_by_test_id("controller")).to_have_value("preview")
    page.get_by_test_id("controller").select_option("paper")
    expect(page.get_by_test_id("K_P-x")).to_be_visible()
    page.get_by_test_id("controller").select_option("preview")
    expect(page.get_by_test_id("tuning-K_I")).to_have_value("4")
    expect(page.get_by_test_id("K_P-x")).to_have_count(0)
    expect(page.get_by_test_id("K_o-x")).to_be_visible()
    field = page.get_by_test_id("tuning-K_P")
    field.fill("0.4")
    field.press("Enter")
    wait_until(lambda: page.evaluate(TUNING)[:2] == [0.4, 4.0])
    shot(page, "controller")
    begin_circle(page)
    expect(page.get_by_test_id("controller")).to_have_count(0)
    page.get_by_role("tab", name="Gains").click()
    expect(page.get_by_test_id("controller")).to_be_disabled()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    page.get_by_role("tab", name="Run").click()
    expect(page.get_by_test_id("run-result").first).to_contain_text("preview")
    shot(page, "controller-result")
    page.get_by_role("tab", name="Gains").click()
    field.fill("0.3")
    field.press("Enter")
    wait_until(lambda: page.evaluate(TUNING)[:2] == [0.3, 4.0])
    page.get_by_role("tab", name="Control").click()
    page.get_by_test_id("disarm").click()
    wait_until(lambda: frame(page)["mode"] == Mode.VENTED)
    page.get_by_test_id("lease-release").click()


@pytest.mark.long
def test_limits_of_figures_are_set_bounded_and_reset_and_passing_red_is_logged(page: Page) -> None:
    operate(page, "Health")
    page.get_by_test_id("alarm-limits").click()
    for colour, limit in (("amber", "0.01"), ("red", "0.02")):
        field = page.get_by_test_id(f"limit-command_age-{colour}")
        field.fill(limit)
        field.press("Enter")
        expect(field).to_have_value(limit)
    expect(page.get_by_test_id("gauge-commandAge")).to_contain_text("bad")
    shot(page, "limits")
    page.get_by_test_id("alarm-limits").click()
    page.get_by_role("tab", name="Log").click()  # the server looks at limits once a second: before they are reset
    expect(page.get_by_test_id("log")).to_contain_text(
        re.compile(r"command age [\d.]+ ms is above the limit of 0.02 ms")
    )
    page.get_by_role("tab", name="Health").click()
    page.get_by_test_id("alarm-limits").click()
    field.fill("0.001")
    field.press("Enter")
    expect(
        page.get_by_text(re.compile(r"command_age red must be greater than or equal to 0\.00001, not 0\.000001"))
    ).to_be_visible()
    expect(field).to_have_value("0.02")
    page.get_by_test_id("alarm-reset").click()
    expect(field).to_have_value("500")
    page.get_by_test_id("alarm-limits").click()
    page.get_by_test_id("lease-release").click()


@pytest.mark.long
def test_a_recording_plays_in_3d_stands_at_its_end_and_begins_again(page: Page) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("record").click()
    wait_until(lambda: frame(page)["tick"] > 0)
    page.wait_for_timeout(1500)
    page.get_by_test_id("record").click()
    page.get_by_text("Review", exact=True).click()
    page.get_by_test_id("recording").first.click()
    page.get_by_test_id("sight").get_by_text("3D").click()
    wait_until(lambda: number(page, "replay-at") > 1)
    toggle = page.get_by_test_id("replay-toggle")
    expect(toggle).to_have_attribute("aria-label", "Play")
    toggle.click()
    expect(toggle).to_have_attribute("aria-label", "Pause")
    toggle.click()
    expect(toggle).to_have_attribute("aria-label", "Play")
    shot(page, "replay")


@pytest.mark.alone  # beside another product the server is silent for a second, and the banner says that instead
def test_the_rig_comes_back_with_another_actuator_and_the_page_follows(page: Page) -> None:
    operate(page, "Actuator")
    here = page.get_by_test_id("actuator-P2").get_attribute("aria-pressed") == "true"  # tried again
    other, former = ("P1", "P2") if here else ("P2", "P1")
    page.get_by_test_id(f"actuator-{other}").click()
    shot(page, "actuator-asked")
    page.get_by_label("Leave the actuator as it is").click()
    expect(page.get_by_test_id("actuator-confirm")).to_have_count(0)
    page.evaluate(NOTE_WORDS)
    page.get_by_test_id(f"actuator-{other}").click()
    page.get_by_test_id("actuator-confirm").click()
    expect(page.get_by_test_id(f"actuator-{other}")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    expect(page.get_by_test_id(f"actuator-{former}")).not_to_have_attribute("aria-disabled", "true")
    said = page.evaluate("window.__said")
    assert said["banner"] and all(f"starts with actuator {other}" in text for text in said["banner"]), said
    assert any(f"The rig starts with {other}; it comes back vented" in text for text in said["actuator-status"]), said
    shot(page, "actuator")


def test_the_observer_takes_the_tables_inertia_and_the_measured_one(page: Page, product: Product) -> None:
    three, now = Interval(value=40.0, low=38.0, high=42.0), datetime.now(UTC)
    mode = MeasuredMode(
        **{name: three for name in ("frequency", "zeta", "kappa")},
        **{name: 0.01 for name in ("friction", "delay", "misfit", "travel")},
        pressures=True,
        repeats=3,
    )
    rig = RigParameters.model_validate(page.request.get(f"{product.origin}/api/rig").json()["parameters"])
    modes = FirstModes(modes_file(product.state, product.rig))
    modes.keep(KeptMode(actuator=rig.actuator, plant=rig.twin.plant, measured=now, mode=mode))
    page.reload()
    operate(page, "Gains")
    button, facts = page.get_by_test_id("observer-kappa"), page.get_by_test_id("first-mode-facts")
    for word, then in (("Table's κ", "1, the actuator's table"), ("Measured κ", "40.0")):
        expect(button).to_contain_text(word)
        button.click()
        page.get_by_test_id("actuator-confirm").click()
        expect(facts).to_contain_text(f"Observer's κ{then}")
        expect(page.get_by_test_id("state")).to_contain_text("VENTED")
        shot(page, f"observer-kappa-{word[0]}")


def test_the_rig_comes_back_on_another_plant_and_the_page_says_so(page: Page) -> None:
    operate(page, "Actuator")
    expect(page.get_by_test_id("plant-rod")).to_have_attribute("aria-pressed", "true")
    page.get_by_test_id("plant-cosserat").click()
    page.get_by_test_id("actuator-confirm").click()
    expect(page.get_by_test_id("actuator-status")).to_contain_text("as a Cosserat rod; it comes back vented")
    expect(page.get_by_test_id("plant-cosserat")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    expect(page.locator(".rig-name")).to_contain_text("Cosserat twin")
    shot(page, "plant")


def test_an_actuator_of_ones_own_comes_from_a_file_and_a_bad_one_is_refused(page: Page, tmp_path: Path) -> None:
    good, bad = tmp_path / "good.toml", tmp_path / "bad.toml"
    write_actuator(PRESETS["P3"].model_copy(update={"name": "Own"}), good)
    bad.write_text(re.sub(r"(?m)^length = .*$", "length = -1", good.read_text()))
    operate(page, "Actuator")
    for file in (bad, good):
        with page.expect_file_chooser() as chooser:
            page.get_by_test_id("actuator-file").click()
        chooser.value.set_files(file)
        page.get_by_test_id("actuator-confirm").click()
        if file == bad:
            expect(page.get_by_text(re.compile(r"length = -1.*greater than"))).to_be_visible()
            shot(page, "actuator-file-refused")
    expect(page.get_by_test_id("actuator-status")).to_contain_text("comes back vented")
    expect(page.locator(".rig-name")).to_contain_text("Own")
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
