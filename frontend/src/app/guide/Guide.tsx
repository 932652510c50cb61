import { Button } from "@mantine/core";
import { useEffect, useRef, useState } from "react";
import { usePage, type Page } from "../../live/page";
import { isMovable, MODE } from "../../live/modes";
import { useService } from "../../ui/services";
import { Ticker } from "../../ui/ticker";

const SEEN = "tendril-guide";

interface Step {
  readonly title: string;
  readonly text: string;
  /** Selectors of the control it points at; the first that is on the page counts. */
  readonly at: readonly string[];
  readonly done: (page: Page) => boolean;
}

const TO_OPERATE: readonly Step[] = [
  {
    title: "Arm",
    text: "Take control, then press Arm: the chambers are pressurised and the actuator holds where it is.",
    at: ["[data-testid=lease-take]", "[data-testid=arm]", ".tabs [role=tab]"],
    done: ({ mode, lease }) => lease.mine && mode !== null && isMovable(mode),
  },
  {
    title: "Drag",
    text: "Drag the ring in the plan (or use the arrow keys): the tip follows. Esc holds, Esc twice is the E-STOP.",
    at: [".plan"],
    done: ({ mode, lease }) => lease.mine && mode === MODE.FOLLOW,
  },
  {
    title: "Record",
    text: "Record keeps every tick. The recording is then found under Review.",
    at: ["[data-testid=record]"],
    done: ({ recording }) => recording.recording,
  },
];

const TO_LOOK: readonly Step[] = [
  {
    title: "Watch",
    text: "The plan shows the measured tip and the observer's backbone as the rig moves. Nothing that you do here moves it.",
    at: [".plan"],
    done: () => false,
  },
  {
    title: "Stop",
    text: "E-STOP is for everyone who looks: it vents the chambers at once, and the log says that it was you.",
    at: ["[data-testid=e-stop]"],
    done: ({ mode }) => mode === MODE.E_STOP,
  },
  {
    title: "Look back",
    text: "Review has the recordings: play, compare and export them.",
    at: [".header [role=radiogroup]"],
    done: ({ view }) => view === "review",
  },
];

/** A few steps for the first visit, beside the real controls; once dismissed they never return. */
export function Guide() {
  const role = usePage(({ me }) => me.role);
  const [step, setStep] = useState(() => (localStorage.getItem(SEEN) === null ? 0 : null));
  const steps = role === "viewer" ? TO_LOOK : TO_OPERATE;
  const finish = () => {
    localStorage.setItem(SEEN, "seen");
    setStep(null);
  };
  if (step === null) return null;
  const next = () => {
    if (step + 1 < steps.length) setStep(step + 1);
    else finish();
  };
  return <Card key={`${role} ${step}`} steps={steps} index={step} onNext={next} onSkip={finish} />;
}

interface CardProps {
  readonly steps: readonly Step[];
  readonly index: number;
  readonly onNext: () => void;
  readonly onSkip: () => void;
}

function Card({ steps, index, onNext, onSkip }: CardProps) {
  const ticker = useService(Ticker);
  const { title, text, at, done } = steps[index];
  const isDone = usePage(done);
  const card = useRef<HTMLElement>(null);
  const ring = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (isDone) onNext();
  }, [isDone, onNext]);
  useEffect(
    () =>
      ticker.every(10, "guide", () => {
        if (card.current && ring.current) place(card.current, ring.current, at);
      }),
    [ticker, at],
  );
  return (
    <>
      <div ref={ring} className="guide-ring" aria-hidden />
      <section ref={card} className="guide" aria-labelledby="guide-title" data-testid="guide">
        <h2 id="guide-title">
          {index + 1} of {steps.length}: {title}
        </h2>
        <p>{text}</p>
        <div className="row">
          <Button size="xs" onClick={onNext} data-testid="guide-next">
            {index + 1 < steps.length ? "Next" : "Done"}
          </Button>
          <Button size="xs" variant="subtle" onClick={onSkip} data-testid="guide-skip">
            Skip the guide
          </Button>
        </div>
      </section>
    </>
  );
}

const GAP = 12;
const EDGE = 8;
/** State and E-STOP have the upper edge. */
const TOP = 60;
/** Lines and banners that say how the rig stands. */
const NEWS = ".over-page, .banner";
/** A control larger than this is pointed at from within. */
const LARGE = 300;

interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** Put the ring round the first element that `selectors` find, and the card beside it, wholly in the window. */
function place(card: HTMLElement, ring: HTMLElement, selectors: readonly string[]): void {
  const found = selectors
    .map((selector) => document.querySelector(selector))
    .find((element) => element !== null);
  ring.hidden = found === undefined;
  const target = found?.getBoundingClientRect() ?? { left: 0, top: 0, width: 0, height: 0 };
  move(ring, target.left - 4, target.top - 4);
  ring.style.width = `${target.width + 8}px`;
  ring.style.height = `${target.height + 8}px`;
  const size = card.getBoundingClientRect();
  const at = cardPlace(target, size, window.innerWidth, window.innerHeight);
  const news = [...document.querySelectorAll(NEWS)].map((element) => element.getBoundingClientRect());
  move(card, at.left, clearOf(news, { ...at, width: size.width, height: size.height }));
}

/** Upper edge of the card at `at`, lower where it would cover what the page has to say about the rig. */
export function clearOf(news: readonly Box[], at: Box): number {
  const covers = (box: Box) =>
    box.left < at.left + at.width &&
    at.left < box.left + box.width &&
    box.top < at.top + at.height &&
    at.top < box.top + box.height;
  return Math.max(at.top, ...news.filter(covers).map((box) => box.top + box.height + GAP));
}

/** Below the control, above it where there is no room, in the lower left corner of a large one. */
export function cardPlace(
  target: Box,
  card: Box,
  width: number,
  height: number,
): { readonly left: number; readonly top: number } {
  const below = target.top + target.height + GAP;
  const above = target.top - card.height - GAP;
  const inside = target.top + target.height - card.height - 4 * GAP;
  const large = target.width > LARGE && target.height > LARGE;
  const top = large ? inside : below + card.height + EDGE <= height ? below : above;
  return {
    left: within(target.left + (large ? GAP : 0), EDGE, width - card.width - EDGE),
    top: within(top, TOP, height - card.height - EDGE),
  };
}

function within(value: number, low: number, high: number): number {
  return Math.max(low, Math.min(value, high));
}

function move(element: HTMLElement, left: number, top: number): void {
  element.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
}
