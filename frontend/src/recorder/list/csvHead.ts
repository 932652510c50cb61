const NAMES: Readonly<Record<string, "time" | "length">> = {
  t: "time",
  time: "time",
  x: "length",
  y: "length",
};

/** Which units the header of a CSV file leaves open; both where it has no header. */
export function unitsMissing(text: string): { readonly time: boolean; readonly length: boolean } {
  const lines = text.replace(/^\uFEFF/, "").split(/\r?\n/);
  const head = lines.find((line) => line.trim() !== "" && !line.trimStart().startsWith("#")) ?? "";
  const delimiter = [";", "\t", ","].find((one) => head.includes(one)) ?? /\s+/;
  const named = head.split(delimiter).flatMap((title) => {
    const match = /^"?([a-z]+)(?:[\s_]*[[(/ _]\s*([a-z]+)\s*[\])]?)?"?$/.exec(title.trim().toLowerCase());
    const kind = match ? NAMES[match[1]] : undefined;
    return kind === undefined || !match
      ? []
      : [{ kind, open: (match[2] as string | undefined) === undefined }];
  });
  const open = (wanted: "time" | "length") => {
    const columns = named.filter(({ kind }) => kind === wanted);
    return columns.length === 0 || columns.some((column) => column.open);
  };
  return { time: open("time"), length: open("length") };
}
