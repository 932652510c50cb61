import { call } from "../api/rest";
import type { ImportedPath } from "../api/types";

/** The path in a CSV file, as the server reads it. Raises Refusal with line, column and value of what is wrong. */
export function readPath(file: File): Promise<ImportedPath> {
  const query = new URLSearchParams({ name: file.name });
  return call<ImportedPath>("POST", `/api/drawings/import?${query.toString()}`, file);
}
