import { createContext, use } from "react";

type Kind<T extends object> = abstract new (...args: never[]) => T;

/** What works behind the page, one of each class: a room asks for what it needs, and only `app` knows who made it. */
export class Services {
  private readonly made = new Map<unknown, object>();

  /** Have each of `services` found by its class. */
  add(...services: readonly object[]): void {
    for (const service of services) this.made.set(service.constructor, service);
  }

  get<T extends object>(kind: Kind<T>): T {
    const found = this.made.get(kind);
    if (found instanceof kind) return found;
    throw new Error(`nothing behind the page is a ${kind.name}`);
  }
}

export const ServicesContext = createContext(new Services());

export function useServices(): Services {
  return use(ServicesContext);
}

export function useService<T extends object>(kind: Kind<T>): T {
  return useServices().get(kind);
}
