"""A path from a table or an SVG file: shown first, with what it is taken as; then imported, or refused in words."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, FilePayload, Page, expect

from tests.e2e.product import Product, open_page, shot, wait_until

pytestmark = pytest.mark.keyed(
    "frontend/src", "server/drawing", "controller/reference", "tests/e2e/*.py", imports=False
)
"""How a room of the page works follows the sources of page and room; what moves or stops a rig is always tested."""

SQUARE = """<svg xmlns="http://www.w3.org/2000/svg" width="60mm" viewBox="0 0 60 60">
  <path d="M 0 0 H 40 V 40 H 0 Z"/>
</svg>"""
DROP = """([name, text]) => {
  const data = new DataTransfer();
  data.items.add(new File([text], name));
  document.querySelector("main").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true }));
}"""
PASTE = """([id, text]) => {
  const field = document.querySelector(`[data-testid=${id}]`), data = new DataTransfer();
  data.setData("text", text);
  field.focus();
  field.select();
  field.dispatchEvent(new ClipboardEvent("paste", { clipboardData: data, bubbles: true, cancelable: true }));
}"""
ZIGZAG = " ".join(f"L {n / 200} {n % 2 * 20}" for n in range(1, 8001))
SHOWN: dict[str, tuple[str, str, str, str]] = {
    "hidden in every way": (
        """<style>.no { display: none } #gone { visibility: hidden } .thin { opacity: 0 }</style>
        <defs><path d="M 0 0 H 59"/><clipPath><rect width="58" height="58"/></clipPath></defs>
        <symbol id="s"><path d="M 0 0 H 57"/></symbol><mask><path d="M 0 0 H 56"/></mask>
        <marker><path d="M 0 0 H 56"/></marker><pattern><path d="M 0 0 H 56"/></pattern>
        <g class="no"><g><path d="M 0 0 H 55"/></g></g><path id="gone" d="M 0 0 H 54"/>
        <g class="thin"><path d="M 0 0 H 53"/></g><g style="display:none"><path d="M 0 0 H 52"/></g>
        <g hidden=""><path d="M 0 0 H 51"/></g><path display="none" d="M 0 0 H 50"/>
        <path fill="none" d="M 0 0 H 49"/><path visibility="collapse" d="M 0 0 H 48"/>
        <g visibility="hidden"><path d="M 0 0 H 47"/><path visibility="visible" d="M 10 20 H 30"/></g>""",
        "1",
        "20.0 mm by 0.0 mm",
        "hidden or unpainted shapes left out: 9",
    ),
    "shapes of every kind": (
        """<rect x="0" y="0" width="10" height="20"/><circle cx="30" cy="10" r="5"/>
        <ellipse cx="30" cy="30" rx="4" ry="8"/>
        <line x1="0" y1="30" x2="0" y2="40" stroke="red"/><polyline points="0,45 5,45 5,50" fill="none" stroke="red"/>
        <polygon points="10,45 20,45 20,50"/><path d="M 40 0 A 10 10 0 0 1 40 20 q 5 5 0 10 t 0 10 s 3 3 0 10"/>""",
        "7",
        "50.0 mm by 50.0 mm",
        "",
    ),
    "several moves, relative ones too": (
        """<path d="m0 0h10v10h-10zm20 20 10 0 0 10M40,40l10 10m-50-10h5"/>""",
        "4",
        "50.0 mm by 50.0 mm",
        "",
    ),
    "nested transforms, a style and a use": (
        """<defs><path id="dash" d="M 0 0 H 10"/></defs><style>.far { transform: translate(10px, 0) }</style>
        <g transform="scale(2)"><g transform="rotate(90)"><path d="M 0 0 H 10"/></g></g>
        <use href="#dash" x="20" y="5"/><g class="far"><use href="#dash" transform="translate(20 10)"/></g>""",
        "3",
        "40.0 mm by 20.0 mm",
        "",
    ),
    "a symbol and a picture in the picture": (
        """<symbol id="box" viewBox="0 0 1 1"><path d="M 0 0 H 1 V 1"/></symbol>
        <use href="#box" x="10" y="10" width="20" height="20"/>
        <svg x="40" y="0" width="10" height="10" viewBox="0 0 100 100"><path d="M 0 0 H 100"/></svg>""",
        "2",
        "40.0 mm by 30.0 mm",
        "",
    ),
    "texts, pictures and clips": (
        """<linearGradient id="g"><stop/></linearGradient><text x="5" y="5">word</text>
        <image width="5" height="5" href="data:,"/>
        <g clip-path="url(#c)"><path fill="url(#g)" d="M 0 0 H 20 V 20"/></g>""",
        "1",
        "20.0 mm by 20.0 mm",
        "texts left out, which are no paths yet: 1",
    ),
    "hidden by selectors of every kind": (
        """<style>@media screen { .screen { display: none } } [data-off="1"], path:nth-child(5) { display: none }
        :root { --gone: none } .gone { display: var(--gone) } use { fill: none }
        desc + path { visibility: hidden }</style>
        <style media="print">.kept { display: none }</style><style type="text/other">.kept { display: none }</style>
        <desc/><path d="M 0 0 H 51"/><defs><path id="u" d="M 0 0 H 52"/></defs><use href="#u"/>
        <g class="screen"><path d="M 0 0 H 53"/></g><g data-off="1"><path d="M 0 0 H 54"/></g>
        <g class="gone"><path d="M 0 0 H 55"/></g><path fill="color(srgb 0 0 0 / 0)" d="M 0 0 H 56"/>
        <path fill="url(#nothing) none" d="M 0 0 H 57"/><line x2="58"/><rect width="59" height="0"/>
        <path class="kept" d="M 10 20 H 30"/>""",
        "1",
        "20.0 mm by 0.0 mm",
        "hidden or unpainted shapes left out: 9",
    ),
    "conditions and switches": (
        """<switch><g systemLanguage="xx"><path d="M 0 0 H 51"/></g><g><path d="M 10 20 H 30"/></g></switch>
        <switch><foreignObject requiredExtensions="http://ns.adobe.com/x"/><g><path d="M 10 20 V 30"/></g></switch>
        <g requiredExtensions="http://example.com/x"><path d="M 0 0 H 52"/></g>
        <switch><text>a</text><path d="M 0 0 H 53"/></switch><path xmlns="http://example.com/" d="M 0 0 H 54"/>""",
        "2",
        "20.0 mm by 10.0 mm",
        "hidden or unpainted shapes left out: 3",
    ),
    "a picture as large as its use": (
        """<defs><svg id="s" viewBox="0 0 4 4"><path d="M 0 0 H 4"/></svg></defs>
        <use href="#s" x="10" y="10" width="40" height="40"/>""",
        "1",
        "40.0 mm by 0.0 mm",
        "",
    ),
    "a clip by a style": (
        """<style>.cut { clip-path: url(#c) }</style><clipPath id="c"><rect width="1" height="1"/></clipPath>
        <g class="cut"><path d="M 0 0 H 20"/></g>""",
        "1",
        "20.0 mm by 0.0 mm",
        "clipped or masked parts followed whole: 1",
    ),
    "off the page": (
        """<path d="M 50 0 H 90"/>""",
        "1",
        "40.0 mm by 0.0 mm",
        "strokes that leave the page followed whole: 1",
    ),
    "moving": (
        """<path d="M 0 0 H 20"><animate attributeName="d" to="M 0 0 H 30" dur="1s"/></path>""",
        "1",
        "20.0 mm by 0.0 mm",
        "animations left out: 1",
    ),
    "an arrow": (
        """<marker id="m"><path d="M 0 0 H 9"/></marker><path marker-end="url(#m)" d="M 0 0 H 20"/>""",
        "1",
        "20.0 mm by 0.0 mm",
        "shapes whose arrow heads or other markers are left out: 1",
    ),
    "more turns than points": (
        f'<path stroke="red" fill="none" d="M 0 0 {ZIGZAG}"/>',
        "1",
        "40.0 mm by 13.3 mm",
        "drawn by 3001 points, which lose",
    ),
}
"""What is drawn on a page of 60 mm, and strokes, extent and a note of what is seen of it."""
BROKEN = {
    "all hidden": (
        '<g display="none"><path d="M 0 0 H 9"/></g>',
        "no path that is seen; hidden or unpainted shapes left out: 1",
    ),
    "only text": ("<text>word</text>", "no path that is seen; texts left out, which are no paths yet: 1"),
    "a use of another file": ('<use href="other.svg#a"/>', "<use> refers to other.svg#a, which is not in the file"),
    "a use of nothing": ('<use href="#a"/>', "<use> refers to #a, which is not in the file"),
    "a circle of uses": ('<g id="a"><use href="#a"/></g>', "<use> of #a contains itself"),
    "a bad path": (
        '<path id="a" d="M 0 0 X 5"/>',
        '<path> 1 (id "a") of the SVG file: its data cannot be read from character 7 ("X 5") on',
    ),
    "a point that is not whole": ('<path d="M 0 0 H 5"/><path d="M 0 0 L 6"/>', "<path> 2 of the SVG file: its data"),
    "a number too few": ('<polygon points="0,0 5,5 9"/>', "<polygon> 1 of the SVG file: its points cannot be read"),
    "a size that is none": ('<rect width="5 mm" height="5"/>', '<rect> 1 of the SVG file: width = "5 mm" is no length'),
    "a transform of CSS": (
        '<g transform="rotate(90deg)"><path d="M 0 0 H 5"/></g>',
        '<g> 1 of the SVG file: transform = "rotate(90deg)" cannot be read',
    ),
    "data in a style": ("<path style=\"d: path('M 0 0 H 5')\"/>", "its data is in a style: write it into d"),
}


def choose(page: Page, name: str, text: str) -> None:
    """Take a file by the button over the plan."""
    with page.expect_file_chooser() as chooser:
        page.get_by_test_id("tool-import").click()
    chooser.value.set_files(FilePayload(name=name, mimeType="text/plain", buffer=text.encode()))
    expect(page.get_by_test_id("import-drawing")).to_be_visible()


def drop(page: Page, name: str, text: str) -> None:
    """Drop a file on the page, in place of one that is shown."""
    page.evaluate(DROP, [name, text])
    expect(page.get_by_role("dialog", name=f"Import {name}", exact=True)).to_be_visible()


def take(page: Page) -> None:
    page.get_by_test_id("import-take").click()
    expect(page.get_by_test_id("import-drawing")).to_have_count(0)


def cancel(page: Page) -> None:
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_test_id("import-drawing")).to_have_count(0)


def fact(page: Page, name: str) -> str:
    """What the dialog says under `name`."""
    return page.locator(f"[data-testid=import-facts] div:has(dt:text-is('{name}')) dd").inner_text()


def length(page: Page) -> str:
    """Length of the drawing as the server has it, "" before it said."""
    said = page.locator("[data-testid=drawing-facts] div:has(dt:text-is('Length')) dd")
    return said.inner_text() if said.count() else ""


def paged(inner: str) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60">{inner}</svg>'


@pytest.fixture
def phone(browser: Browser, product: Product) -> Iterator[Page]:
    """A telephone in the hand."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True)
    yield open_page(context, product)
    context.close()


def test_an_svg_path_is_shown_and_imported_under_the_name_of_its_file(page: Page) -> None:
    page.get_by_role("tab", name="Run").click()
    choose(page, "square.svg", SQUARE)
    expect(page.get_by_test_id("import-reach")).to_contain_text("Reach: ")
    assert (fact(page, "Strokes"), fact(page, "Length"), fact(page, "Extent")) == (
        "1",
        "160.0 mm",
        "40.0 mm by 40.0 mm",
    )
    expect(page.get_by_test_id("import-picture")).to_be_visible()
    shot(page, "import-svg")
    take(page)
    expect(page.get_by_role("radio", name="Drawing")).to_be_checked()
    expect(page.get_by_test_id("drawing-name")).to_have_value("square")
    expect(page.get_by_test_id("piece-size")).to_have_value("40")
    wait_until(lambda: length(page) == "160 mm")
    page.get_by_test_id("clear-drawing").click()
    expect(page.get_by_test_id("piece-size")).to_have_count(0)

    drop(page, "pixels.svg", SQUARE.replace('width="60mm" ', ""))
    expect(page.get_by_test_id("import-question")).to_have_text("Say how long a unit is: the file does not")
    expect(page.get_by_test_id("import-take")).to_be_disabled()
    assert fact(page, "Length") == "\N{EN DASH}"
    page.get_by_test_id("import-scale").select_option(label="1 pt (1/72 in)")
    assert fact(page, "Extent") == "14.1 mm by 14.1 mm"
    cancel(page)
    expect(page.get_by_test_id("piece-size")).to_have_count(0)

    choose(page, "broken.svg", SQUARE.replace("</svg>", ""))
    problem = page.get_by_test_id("import-problem")
    expect(problem).to_contain_text("The SVG file is broken: error on line 3")
    expect(problem).not_to_contain_text("rendering")
    expect(page.get_by_test_id("import-take")).to_be_disabled()
    shot(page, "import-broken")
    cancel(page)


def test_what_an_svg_file_hides_is_left_out_and_the_rest_is_as_browsers_show_it(page: Page) -> None:
    found = {}
    for name, (inner, *_) in SHOWN.items():
        drop(page, f"{name}.svg", paged(inner))
        expect(page.get_by_test_id("import-facts").or_(page.get_by_test_id("import-problem"))).to_be_visible()
        said = [fact(page, "Strokes"), fact(page, "Extent"), page.get_by_test_id("import-notes").inner_text()]
        found[name] = said
    for name, (_, strokes, extent, note) in SHOWN.items():
        assert found[name][:2] == [strokes, extent], name
        assert note in found[name][2], name
    for name, (inner, words) in BROKEN.items():
        drop(page, f"{name}.svg", paged(inner))
        expect(page.get_by_test_id("import-problem")).to_contain_text(words)
    cancel(page)


def test_a_table_is_imported_as_its_header_says_or_as_it_is_chosen(page: Page) -> None:
    page.get_by_role("tab", name="Run").click()
    choose(page, "stroke.csv", "y_cm,x_cm,t [ms]\n14,2,0\n14,4,2000\n")
    expect(page.get_by_test_id("import-take")).to_be_enabled()
    assert [fact(page, name) for name in ("Rows", "Duration", "Length")] == ["2", "2.00 s", "20.0 mm"]
    take(page)
    expect(page.get_by_test_id("piece-size")).to_have_value("20")
    wait_until(lambda: length(page) == "20 mm")
    expect(page.get_by_test_id("timing")).to_have_value("given")
    expect(page.get_by_test_id("drawing-name")).to_have_value("stroke")
    page.get_by_test_id("clear-drawing").click()
    expect(page.get_by_test_id("timing")).to_have_value("speed")

    choose(page, "plain.csv", "0;9;20;140\n1;9;50;140,5\n")
    expect(page.get_by_test_id("import-question")).to_have_text("Say which column is x and which is y")
    page.get_by_test_id("import-column-3").select_option("x")
    page.get_by_test_id("import-column-4").select_option("y")
    expect(page.get_by_test_id("import-question")).to_have_text("Say in which unit x and y are: the file does not")
    page.get_by_test_id("import-unit-y").select_option("mm")
    page.get_by_test_id("import-column-1").select_option("t")
    expect(page.get_by_test_id("import-question")).to_have_text("Say in which unit t is: the file does not")
    page.get_by_test_id("import-unit-t").select_option("s")
    expect(page.get_by_test_id("import-take")).to_be_enabled()
    expect(page.get_by_test_id("import-columns")).to_contain_text("140.50 mm")
    shot(page, "import-table")
    page.get_by_test_id("import-times").get_by_text("Without times").click()
    take(page)
    expect(page.get_by_test_id("piece-size")).to_have_value("30")
    expect(page.get_by_test_id("timing")).to_have_value("speed")

    for name, text, words in (
        ("empty.csv", "x_mm,y_mm\n10,20\n,21\n", "empty.csv, line 3: x_mm is empty"),
        ("picture.csv", "PNG\0", "picture.csv, line 1: a zero byte, which is no text"),
        ("data.json", '{"x": 1}', "data.json is JSON, not a table of numbers in text: save it as CSV in UTF-8"),
    ):
        choose(page, name, text)
        expect(page.get_by_test_id("import-problem")).to_contain_text(words)
        expect(page.get_by_test_id("import-take")).to_be_disabled()
        shot(page, f"import-{name.split('.')[0]}")
        cancel(page)
    expect(page.get_by_test_id("piece-size")).to_have_value("30")


def test_a_pasted_decimal_comma_is_a_number_and_what_is_none_is_said(page: Page) -> None:
    page.get_by_role("tab", name="Run").click()
    page.get_by_text("Drawing", exact=True).click()
    page.evaluate(PASTE, ["smoothing", "0,5"])
    expect(page.get_by_test_id("smoothing")).to_have_value("0.5")
    page.evaluate(PASTE, ["smoothing", "1.234,5"])
    expect(page.get_by_role("alert").filter(has_text="Not pasted")).to_contain_text('"1.234,5" is not a number')
    expect(page.get_by_test_id("smoothing")).to_have_value("0.5")


def test_the_dialog_fits_a_phone_and_is_used_by_keys_alone(phone: Page) -> None:
    rows = "".join(f"{n * 100},{140 + n},{20 + n * n / 10:.1f},note\n" for n in range(40))
    drop(phone, "phone.csv", "time,y,x,remark\n" + rows)
    dialog = phone.get_by_test_id("import-drawing")
    phone.get_by_test_id("import-unit-y").focus()
    phone.keyboard.type("mm")
    phone.get_by_test_id("import-unit-t").focus()
    phone.keyboard.type("ms")
    expect(phone.get_by_test_id("import-take")).to_be_enabled()
    assert fact(phone, "Duration") == "3.90 s"
    box = dialog.bounding_box()
    assert box is not None and box["x"] >= 0 and box["x"] + box["width"] <= 390
    assert phone.evaluate("document.documentElement.scrollWidth") <= 390
    shot(phone, "import-phone")
    phone.get_by_test_id("import-take").scroll_into_view_if_needed()
    shot(phone, "import-phone-end")
    phone.get_by_test_id("import-take").focus()
    phone.keyboard.press("Enter")
    expect(dialog).to_have_count(0)
    drop(phone, "phone.csv", rows)
    phone.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
