import { useEffect, useEffectEvent, useState } from "react";
import type { Painter, Painters } from "./painters";
import { useService } from "./services";

interface Task extends Painter {
  readonly period: number;
  readonly run: (now: number) => void;
  due: number;
}

/** One animation-frame loop for everything that follows the stream without React. */
export class Ticker {
  private readonly tasks = new Set<Task>();
  private running = false;

  constructor(private readonly painters: Painters) {}

  /** Call `run`, which draws `name`, at most `rate` times a second, on animation frames; returns how to stop it. */
  every(rate: number, name: string, run: (now: number) => void): () => void {
    const task = { name, period: 1000 / rate, run, due: 0 };
    this.tasks.add(task);
    if (!this.running) this.next();
    return () => {
      this.tasks.delete(task);
      this.painters.recovered(task);
    };
  }

  private next(): void {
    this.running = true;
    requestAnimationFrame((now) => {
      for (const task of this.tasks) this.runIfDue(task, now);
      if (this.tasks.size > 0) this.next();
      else this.running = false;
    });
  }

  private runIfDue(task: Task, now: number): void {
    if (now < task.due) return;
    task.due = Math.max(task.due + task.period, now + task.period / 2);
    this.painters.run(task, now, () => {
      task.run(now);
    });
  }
}

/** Do `action`, as the last render gave it, `rate` times a second. */
export function useTick(rate: number, action: () => void): void {
  const ticker = useService(Ticker);
  const tick = useEffectEvent(action);
  useEffect(
    () =>
      ticker.every(rate, "number", () => {
        tick();
      }),
    [ticker, rate],
  );
}

/** A value of the stream, looked at `rate` times a second; renders only when it changed. */
export function useSampled<T extends number | string | boolean>(read: () => T, rate: number): T {
  const [value, setValue] = useState(read);
  useTick(rate, () => {
    setValue(read);
  });
  return value;
}
