"""The page on a rig of devices: drivers, rig file and commissioning, against a virtual rig on its real wires."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from controller.realtime.ring import find_ring
from controller.virtual.process import VirtualProcess
from tests.e2e.devices import driven
from tests.e2e.product import Product, open_page, shot, wait_until
from tests.e2e.ui.test_accessibility import in_both_schemes, load_axe, look

pytestmark = [
    pytest.mark.alone,
    pytest.mark.keyed(
        "frontend/src", "server/hardware", "controller/virtual", "controller/drivers", "tests/e2e/*.py", imports=False
    ),
]

JOGGED = 5e3
"""A chamber that shows more than this is filled [Pa]."""


@pytest.fixture(scope="module")
def devices(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Product, VirtualProcess]]:
    """A product that drives a virtual rig, for all tests of this file."""
    with driven(tmp_path_factory.mktemp("devices")) as both:
        yield both


@pytest.fixture(scope="module")
def opened_page(browser: Browser, devices: tuple[Product, VirtualProcess]) -> Iterator[Page]:
    """One page on its tab Rig."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    page = open_page(context, devices[0])
    page.get_by_role("tab", name="Rig").click()
    yield page
    context.close()


@pytest.fixture
def rig_page(opened_page: Page) -> Page:
    """The operator's: axe in the test before may have kept a slow page from giving presence until its lease lapsed."""
    if opened_page.get_by_test_id("lease").get_attribute("data-mine") != "true":
        opened_page.get_by_test_id("lease-take").click()
        expect(opened_page.get_by_test_id("lease")).to_have_attribute("data-mine", "true")
    return opened_page


def section(page: Page, name: str) -> None:
    """Go to a part of the tab Rig."""
    page.get_by_test_id("rig-section").get_by_text(name, exact=True).click()


def pressures(product: Product) -> list[float]:
    """Measured in the four chambers [Pa]."""
    row = find_ring(product.rig).newest()
    assert row is not None
    return [float(one) for one in row["pressure_meas"]]


def opened(page: Page, step: str) -> Locator:
    """A step of the commissioning, with its body shown."""
    card = page.get_by_test_id(f"step-{step}")
    head = card.get_by_role("button", expanded=False)
    if head.count():
        head.first.click()
    return card


def test_both_drivers_are_shown_running_with_their_raw_values(rig_page: Page) -> None:
    for role, raw in (("motion_capture", "#10"), ("valves", "pressures")):
        expect(rig_page.get_by_test_id(f"driver-state-{role}")).to_contain_text("running")
        expect(rig_page.get_by_test_id(f"driver-{role}")).to_contain_text(raw)
        expect(rig_page.get_by_test_id(f"driver-trouble-{role}")).to_be_empty()
    expect(rig_page.get_by_test_id("not-commissioned")).to_contain_text("frame assumed, not measured")
    shot(rig_page, "hardware-drivers")


def test_what_only_a_twin_has_is_not_there(rig_page: Page) -> None:
    rig_page.get_by_role("tab", name="Sensing").click()
    expect(rig_page.get_by_test_id("sense-10")).to_be_visible()
    for name in ("faults", "twin-pause"):
        expect(rig_page.get_by_test_id(name)).to_have_count(0)
    rig_page.get_by_role("tab", name="Actuator").click()
    expect(rig_page.get_by_test_id("actuator-facts")).to_be_visible()
    expect(rig_page.get_by_test_id("plant-cosserat")).to_have_count(0)
    rig_page.get_by_role("tab", name="Rig").click()


def test_axe_finds_nothing_serious_in_any_part_of_the_tab(rig_page: Page) -> None:
    load_axe(rig_page)
    findings = []
    for name in ("Drivers", "Rig file", "Commissioning"):
        section(rig_page, name)
        findings += look(rig_page, name, ".rig-panel")
    assert not findings, "\n".join(findings)


def test_a_wrong_rig_file_is_refused_beside_the_line_with_field_value_and_bound(rig_page: Page) -> None:
    section(rig_page, "Rig file")
    text = rig_page.get_by_test_id("rig-file-text")
    standing = rig_page.get_by_test_id("rig-file-standing")
    expect(standing).to_contain_text("In force")
    before = text.input_value()
    text.fill(before.replace('driver = "modbus"', 'driver = "modbus"\npressure_max = 5e9'))
    expect(standing).to_contain_text("not saved")
    rig_page.get_by_test_id("rig-file-save").click()
    problem = rig_page.get_by_test_id("rig-file-problem")
    expect(problem).to_contain_text("valves.pressure_max = 5000000000.0 must be less than or equal to 1000000")
    line = 1 + before.split("\n").index('driver = "modbus"') + 1
    expect(problem).to_contain_text(f"Line {line}:")
    shot(rig_page, "hardware-problem")
    rig_page.get_by_test_id("rig-file-revert").click()
    expect(text).to_have_value(before)
    expect(problem).to_be_empty()


def test_every_step_of_the_commissioning_is_reached_and_says_what_it_lacks(rig_page: Page) -> None:
    section(rig_page, "Commissioning")
    steps = rig_page.locator("[data-testid=commissioning] .step")
    expect(steps).to_have_count(9)
    for name in ("drivers", "frame", "signs", "pressure", "statics", "decay", "identify", "closed_loop"):
        card = opened(rig_page, name)
        expect(card.get_by_test_id(f"step-start-{name}")).to_be_visible()
        if name == "pressure":
            number = card.get_by_test_id("input-pressure-pressure")
            number.click()
            rig_page.keyboard.type("25.50")
            expect(number).to_have_value("25.50")
            number.clear()
    expect(rig_page.get_by_test_id("step-closed_loop")).to_contain_text("Actuator must be accepted first")
    expect(rig_page.get_by_test_id("step-start-closed_loop")).to_have_attribute("aria-disabled", "true")


def test_a_chamber_fills_while_its_button_is_held_and_not_after_its_release(
    rig_page: Page, devices: tuple[Product, VirtualProcess]
) -> None:
    product = devices[0]
    section(rig_page, "Commissioning")
    card = opened(rig_page, "jog")
    card.get_by_test_id("step-start-jog").click()
    expect(card.get_by_test_id("jog-u1+")).to_have_count(0)
    card.get_by_test_id("jog-clear").click()
    expect(card.get_by_test_id("jog-filled-u2+-u2+")).to_have_attribute("aria-disabled", "true")
    button = card.get_by_test_id("jog-u2+")
    for press, release in (
        (lambda: (button.hover(), rig_page.mouse.down()), rig_page.mouse.up),
        (lambda: (button.focus(), rig_page.keyboard.down("Space")), lambda: rig_page.keyboard.up("Space")),
        (lambda: (button.hover(), rig_page.mouse.down()), lambda: rig_page.mouse.move(400.0, 400.0)),
    ):
        press()
        wait_until(lambda: pressures(product)[2] > JOGGED)
        assert [one > JOGGED for one in pressures(product)] == [False, False, True, False]
        release()
        expect(button).to_have_attribute("aria-pressed", "false")
        wait_until(lambda: max(pressures(product)) < JOGGED)
        rig_page.mouse.up()
    shot(rig_page, "hardware-jog")
    findings = in_both_schemes(rig_page, "jog", "[data-testid=jog]")
    assert not findings, "\n".join(findings)
    card.get_by_test_id("step-stop-jog").click()
    expect(card.get_by_test_id("step-word-jog")).to_contain_text("failed")
    expect(card.get_by_test_id("step-result-jog")).to_contain_text("stopped by")


def test_valves_that_are_unplugged_are_shown_as_lost_with_a_sentence(
    rig_page: Page, devices: tuple[Product, VirtualProcess]
) -> None:
    section(rig_page, "Drivers")
    devices[1].do("unplug valves")
    state = rig_page.get_by_test_id("driver-state-valves")
    expect(state).to_contain_text("lost")
    expect(rig_page.get_by_test_id("driver-trouble-valves")).not_to_be_empty()
    expect(rig_page.get_by_test_id("driver-state-motion_capture")).to_contain_text("running")
    shot(rig_page, "hardware-lost")
    devices[1].do("plug valves")
    expect(state).to_contain_text("running")
