"""The ways of Review, as its tests take them."""

from playwright.sync_api import FilePayload, Page, expect

COLOURED = """() => [...document.querySelectorAll("[data-testid=quick-plot] canvas")].map((canvas) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let found = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [low, high] = [Math.min(data[i], data[i + 1], data[i + 2]), Math.max(data[i], data[i + 1], data[i + 2])];
    if (data[i + 3] > 128 && high - low > 40) found += 1;
  }
  return found;
})"""


def review(page: Page) -> None:
    page.get_by_text("Review", exact=True).click()


def open_link(page: Page, hash: str) -> None:
    """As a link within the page does."""
    page.evaluate("(hash) => { location.hash = hash; }", hash)


def choose_csv(page: Page, text: str) -> None:
    """Take a file by the button over the list."""
    with page.expect_file_chooser() as chooser:
        page.get_by_test_id("import-recording").click()
    chooser.value.set_files(FilePayload(name="theirs.csv", mimeType="text/csv", buffer=text.encode()))
    expect(page.get_by_test_id("import")).to_be_visible()


def coloured(page: Page) -> list[int]:
    """How many pixels of each quick plot have a colour: its curves, not its grid."""
    return page.evaluate(COLOURED)  # type: ignore[no-any-return]
