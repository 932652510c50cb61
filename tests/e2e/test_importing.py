"""A path from an SVG or CSV file: by the button, dropped on the page, and one that is broken."""

from playwright.sync_api import FilePayload, Page, expect

from tests.e2e.product import shot, wait_until

SQUARE = """<svg xmlns="http://www.w3.org/2000/svg" width="60mm" viewBox="0 0 60 60">
  <path d="M 0 0 H 40 V 40 H 0 Z"/>
</svg>"""
DROP = """([name, text]) => {
  const data = new DataTransfer();
  data.items.add(new File([text], name));
  document.querySelector("main").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true }));
}"""


def choose(page: Page, name: str, text: str) -> None:
    """Take a file by the button over the plan."""
    with page.expect_file_chooser() as chooser:
        page.get_by_test_id("tool-import").click()
    chooser.value.set_files(FilePayload(name=name, mimeType="image/svg+xml", buffer=text.encode()))


def length(page: Page) -> str:
    """Length of the drawing as the server has it, "" before it said."""
    said = page.locator("[data-testid=drawing-facts] div:has(dt:text-is('Length')) dd")
    return said.inner_text() if said.count() else ""


def test_an_svg_path_is_chosen_or_dropped_and_a_broken_one_says_why(page: Page) -> None:
    page.get_by_role("tab", name="Run").click()
    choose(page, "square.svg", SQUARE)
    expect(page.get_by_role("radio", name="Drawing")).to_be_checked()
    expect(page.get_by_test_id("piece-size")).to_have_value("40")
    wait_until(lambda: length(page) == "160 mm", 5.0)
    shot(page, "import-svg")

    page.get_by_test_id("clear-drawing").click()
    expect(page.get_by_test_id("piece-size")).to_have_count(0)
    page.evaluate(DROP, ["half.svg", SQUARE.replace("60mm", "30mm")])
    expect(page.get_by_test_id("piece-size")).to_have_value("20")
    wait_until(lambda: length(page) == "80 mm", 5.0)

    choose(page, "broken.svg", SQUARE.replace("</svg>", ""))
    notice = page.get_by_role("alert").filter(has_text="broken.svg not imported")
    expect(notice).to_contain_text("The SVG file is broken: error on line 3")
    expect(notice).not_to_contain_text("rendering")
    page.evaluate(DROP, ["empty.svg", '<svg xmlns="http://www.w3.org/2000/svg"/>'])
    expect(page.get_by_role("alert").filter(has_text="empty.svg not imported")).to_contain_text("no path")
    expect(page.get_by_test_id("piece-size")).to_have_value("20")
    shot(page, "import-broken")


def test_a_csv_path_is_read_by_the_server_which_says_what_it_assumed_or_what_is_wrong(page: Page) -> None:
    page.get_by_role("tab", name="Run").click()
    choose(page, "stroke.csv", "y_cm,x_cm,t [ms]\n14,2,0\n14,4,2000\n")
    expect(page.get_by_test_id("piece-size")).to_have_value("20")
    wait_until(lambda: length(page) == "20 mm", 5.0)
    expect(page.get_by_test_id("timing")).to_have_value("given")
    page.get_by_test_id("clear-drawing").click()

    choose(page, "plain.csv", "20,140\n50,140\n")
    expect(page.get_by_test_id("piece-size")).to_have_value("30")
    notice = page.get_by_role("alert").filter(has_text="plain.csv imported")
    expect(notice).to_contain_text("no header: the columns are x, y")
    expect(notice).to_contain_text("x has no unit: taken as mm, as some values are beyond 2")

    choose(page, "empty.csv", "10,20,\n11,21,\n")
    problem = page.get_by_role("alert").filter(has_text="empty.csv not imported")
    expect(problem).to_contain_text("empty.csv, line 1: y is empty")
    expect(page.get_by_test_id("piece-size")).to_have_value("30")
