import { api, asCsv, dataOf } from "../api/rest";
import type { ImportedPath } from "../api/types";

/** The path in a CSV file, as the server reads it. Raises Refusal with line, column and value of what is wrong. */
export function readPath(file: File): Promise<ImportedPath> {
  const params = { query: { name: file.name } };
  return dataOf(api.POST("/api/drawings/import", { params, ...asCsv(file) }));
}
