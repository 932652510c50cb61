import { Unreachable } from "./rest";

/** What an answer of JSON lines says, line by line as it comes; raises Unreachable where it breaks off. */
export async function* jsonLines<Line>(answer: ReadableStream<BufferSource> | null): AsyncGenerator<Line> {
  if (!answer) return;
  const reader = answer.pipeThrough(new TextDecoderStream()).getReader();
  let begun = "";
  try {
    for (;;) {
      const { done, value } = await reader.read().catch((error: unknown) => {
        throw new Unreachable(`The server's answer broke off (${String(error)})`);
      });
      if (done) return;
      const lines = (begun + value).split("\n");
      begun = lines.pop() ?? "";
      for (const line of lines) yield JSON.parse(line) as Line;
    }
  } finally {
    await reader.cancel().catch(() => undefined); // the server need not go on for no one
  }
}
