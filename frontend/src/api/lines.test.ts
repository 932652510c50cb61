import { expect, test } from "vitest";
import { jsonLines } from "./lines";
import { Unreachable } from "./rest";

const bytes = (text: string) => new TextEncoder().encode(text);

async function gathered(stream: ReadableStream<Uint8Array<ArrayBuffer>>): Promise<unknown[]> {
  const found: unknown[] = [];
  for await (const line of jsonLines(stream)) found.push(line);
  return found;
}

test("lines are told whole, wherever the network cuts them, also within a letter", async () => {
  const sent = bytes('{"a":1}\n{"b":"ü"}\n');
  for (let cut = 0; cut <= sent.length; cut += 1) {
    const stream = new ReadableStream<Uint8Array<ArrayBuffer>>({
      start(at) {
        at.enqueue(sent.slice(0, cut));
        at.enqueue(sent.slice(cut));
        at.close();
      },
    });
    expect(await gathered(stream)).toEqual([{ a: 1 }, { b: "ü" }]);
  }
});

test("an answer that breaks off says so, after what came", async () => {
  let asked = 0;
  const stream = new ReadableStream<Uint8Array<ArrayBuffer>>({
    pull(at) {
      asked += 1;
      if (asked === 1) at.enqueue(bytes("1\n"));
      else at.error(new TypeError("network error"));
    },
  });
  const found: unknown[] = [];
  const reading = async () => {
    for await (const line of jsonLines(stream)) found.push(line);
  };
  await expect(reading()).rejects.toThrow(Unreachable);
  expect(found).toEqual([1]);
});

test("who stops reading hangs up", async () => {
  let cancelled = false;
  const stream = new ReadableStream<Uint8Array<ArrayBuffer>>({
    pull(at) {
      at.enqueue(bytes("1\n"));
    },
    cancel() {
      cancelled = true;
    },
  });
  for await (const line of jsonLines(stream)) if (line === 1) break;
  expect(cancelled).toBe(true);
});
