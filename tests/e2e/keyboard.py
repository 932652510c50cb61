"""Someone with a keyboard only: every stop of the focus is seen, and it is never lost."""

from playwright.sync_api import Page, expect

HERE = """() => {
  const at = document.activeElement;
  if (!at || at === document.body) return ["", "the focus is nowhere"];
  const label = at.matches("input[type=radio], input[type=checkbox]") ? at.labels?.[0] ?? at.parentElement : null;
  const shown = label ?? at;
  shown.scrollIntoView({ block: "nearest", inline: "nearest", behavior: "instant" });
  const { left, top, right, bottom } = shown.getBoundingClientRect();
  const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
  const marked = [at, label].some((one) => {
    if (!one) return false;
    const { outlineStyle, outlineWidth, borderColor, color } = getComputedStyle(one);
    return outlineStyle !== "none" && parseFloat(outlineWidth) >= 2;
  });
  const name = at.dataset.testid || at.getAttribute("aria-label") || at.innerText || at.value;
  if (!marked) return [name, `the focus on ${at.outerHTML.slice(0, 150)} is not seen`];
  const covered = !hit || !(shown.contains(hit) || hit.contains(shown));
  return [name, covered ? `${at.outerHTML.slice(0, 150)} lies under ${hit?.outerHTML.slice(0, 100)}` : ""];
}"""
"""Name of what has the focus, and what is wrong with that."""


class Keys:
    """Presses, and looks after each press where the focus is."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self.amiss: list[str] = []

    def press(self, *keys: str) -> None:
        """One after the other."""
        for key in keys:
            self._page.keyboard.press(key)

    def look(self) -> str:
        """Name of what has the focus now; what is wrong with it is noted."""
        name, amiss = self._page.evaluate(HERE)
        if amiss:
            self.amiss.append(amiss)
        return str(name)

    def at(self, test_id: str) -> None:
        """The focus has come here by itself, in place of what was pressed, and a press counts."""
        expect(self._page.get_by_test_id(test_id)).to_be_focused()
        self.look()
        self._wait()

    def _wait(self) -> None:
        """A button that has just taken another one's place takes no press yet, nor one that is not allowed now."""
        expect(self._page.locator(":focus")).not_to_have_attribute("data-unread", "true")
        expect(self._page.locator(":focus")).not_to_have_attribute("aria-disabled", "true")

    def go(self, test_id: str, *, back: bool = False, most: int = 12) -> None:
        """Tab until the focus is there, `most` times."""
        stops = []
        for _ in range(most):
            self.press("Shift+Tab" if back else "Tab")
            stops.append(self.look())
            if self._page.evaluate("document.activeElement.dataset.testid") == test_id:
                return self._wait()
        raise AssertionError(f"{test_id} is not among the next {most} stops: {stops}")
