/**
 * Where the keyboard is must never be nowhere. What has the focus may vanish by its own press: a button that becomes
 * another, a row that is deleted, a view that is left, a popover that closes. Browsers then start again at the top of
 * the page. Here the focus goes to what stands in its place.
 */

/** What it goes to first, of all that has taken its place. */
const HOME = "[data-focus-home]";
const REACHED_BY_TAB = "a[href], button, input, select, textarea, [tabindex]:not([tabindex='-1'])";

/** An element around the focus, or the focused one itself, and its place in its parent. */
interface Step {
  readonly element: Element;
  readonly parent: Element;
  readonly index: number;
}

export class FocusKeeper {
  private trail: readonly Step[] = [];
  private trailOfRoot: readonly Step[] = [];
  /** What was pressed last; a pointer that presses elsewhere wants no focus back. */
  private pressed: "key" | "tab" | "pointer" = "pointer";

  private due: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly root: Element) {}

  start(): void {
    const hear = (event: KeyboardEvent) => {
      this.pressed = event.key === "Tab" ? "tab" : "key";
      // A key that is held down presses one button, not also what takes its place.
      if (event.repeat && event.key === "Enter" && document.activeElement instanceof HTMLButtonElement)
        event.preventDefault();
    };
    document.addEventListener("keydown", hear, true);
    document.addEventListener("pointerdown", () => { this.pressed = "pointer"; }, true); // prettier-ignore
    document.addEventListener("focusin", ({ target }) => {
      if (target instanceof Element) this.note(target);
    });
    const seen = new MutationObserver(() => {
      this.look();
    });
    seen.observe(this.root.ownerDocument.body, {
      subtree: true,
      childList: true,
      attributes: true,
      attributeFilter: ["hidden", "disabled"],
    });
  }

  /** What lies over the page (menus, popovers, dialogs) is outside the root: behind it is where it was opened from. */
  private note(focused: Element): void {
    this.trail = stepsFrom(focused);
    if (this.root.contains(focused)) this.trailOfRoot = this.trail;
    else this.trail = [...this.trail, ...this.trailOfRoot];
  }

  private look(): void {
    const own = this.trail.at(0)?.element;
    if (!own) return;
    if (document.activeElement === own) this.note(own); // what is around it may have changed
    if (document.activeElement !== document.body) return;
    if (this.pressed === "pointer")
      this.trail = []; // lost by a click, or given up by one
    else if (this.pressed === "tab" && isThere(own))
      return; // out of the page, on purpose
    else if (!own.matches("[data-loading]:disabled")) this.restore(); // that one comes back
  }

  /** Not at once: a key that is just being pressed would press what has the focus then. */
  private restore(): void {
    clearTimeout(this.due);
    this.due = setTimeout(() => {
      if (document.activeElement === document.body) find(this.trail)?.focus();
    });
  }
}

/** How long what shall get the focus may take to appear [ms]. */
const SUCCESSOR_WAIT_MS = 3000;

/** Focus the first that `selector` finds, once it is there; not if something was pressed meanwhile. */
export function focusWhenThere(selector: string): void {
  const until = performance.now() + SUCCESSOR_WAIT_MS;
  const given = new AbortController();
  for (const kind of ["keydown", "pointerdown"])
    window.addEventListener(kind, () => given.abort(), { capture: true, signal: given.signal }); // prettier-ignore
  const look = () => {
    if (given.signal.aborted) return;
    const found = [...document.querySelectorAll(selector)].find(isUsable);
    if (found || performance.now() > until) given.abort();
    else requestAnimationFrame(look);
    found?.focus();
  };
  requestAnimationFrame(look);
}

function stepsFrom(element: Element): readonly Step[] {
  const steps: Step[] = [];
  for (let at = element; at.parentElement && at !== document.body; at = at.parentElement)
    steps.push({ element: at, parent: at.parentElement, index: [...at.parentElement.children].indexOf(at) });
  return steps.filter(({ parent }) => parent !== document.body);
}

/** The element itself where it is back, else what is nearest to its place, from the inside out. */
function find(trail: readonly Step[]): HTMLElement | null {
  for (const { element, parent, index } of trail) {
    if (element.matches(REACHED_BY_TAB) && isUsable(element)) return element;
    if (!isThere(parent)) continue;
    const around = [...parent.children];
    const inOrder = [...around.slice(index), ...around.slice(0, index).reverse()];
    const likely = element.matches(HOME)
      ? [...inOrder.filter((one) => one.matches(HOME)), ...inOrder]
      : inOrder;
    for (const one of likely) {
      const found = firstIn(one);
      if (found) return found;
    }
  }
  return null;
}

function firstIn(place: Element): HTMLElement | null {
  if (!isThere(place)) return null;
  for (const wanted of [HOME, REACHED_BY_TAB])
    for (const one of [place, ...place.querySelectorAll(wanted)])
      if (one.matches(wanted) && isUsable(one)) return one;
  return null;
}

function isThere(element: Element): boolean {
  return element.isConnected && element.checkVisibility({ visibilityProperty: true });
}

function isUsable(element: Element): element is HTMLElement {
  return element instanceof HTMLElement && isThere(element) && !element.matches(":disabled, [inert] *");
}
