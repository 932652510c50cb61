import { existsSync, readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative, resolve, sep } from "node:path";

/** The rooms of src/, a floor a line from top to bottom: each imports from the floors below its own, from no other. */
const FLOORS = [
  ["app"],
  ["recorder"],
  ["plan", "scene"],
  ["runs"],
  ["drawing"],
  ["hardware", "health", "plots"],
  ["operate"],
  ["live"],
  ["ui"],
  ["api"],
];
/** What a newcomer can count. How many files a folder holds is judged by looking. */
const ROOMS_MAX = 13;

const SRC = join(import.meta.dirname, "src");
const SOURCE = /\b(?:from|import|import\(|URL\()\s*"(\.[^"]+)"/g;
const ENDINGS = ["", ".ts", ".tsx", ".d.ts"];

const roomOf = (file) => relative(SRC, file).split(sep)[0];
const floorOf = (file) => FLOORS.findIndex((rooms) => rooms.includes(roomOf(file)));

/** Fail where the list is not what lies in src/, or is too long to be read at a glance. */
function checkList() {
  const [listed, found] = [FLOORS.flat(), readdirSync(SRC)];
  const amiss = [
    ...found.filter((room) => !listed.includes(room)).map((room) => `src/${room} is in no line of FLOORS`),
    ...listed.filter((room) => !found.includes(room)).map((room) => `there is no src/${room}`),
  ];
  if (found.length > ROOMS_MAX) amiss.push(`${found.length} rooms, more than ${ROOMS_MAX}`);
  if (amiss.length > 0) throw new Error(`rooms.js: ${amiss.join("; ")}`);
}

function resolved(file, source) {
  const path = resolve(dirname(file), source);
  return ENDINGS.map((ending) => path + ending).find((name) => existsSync(name)) ?? path;
}

function importsOf(file) {
  return [...readFileSync(file, "utf8").matchAll(SOURCE)].map(([, source]) => resolved(file, source));
}

/** Whether `file` comes to import `goal`; within their room, as none is entered from below. */
function leadsTo(file, goal, seen = new Set()) {
  if (file === goal) return true;
  if (seen.has(file) || roomOf(file) !== roomOf(goal) || !/\.tsx?$/.test(file)) return false;
  seen.add(file);
  return importsOf(file).some((next) => leadsTo(next, goal, seen));
}

function amissIn(file, source) {
  const other = resolved(file, source);
  if (roomOf(other) === roomOf(file))
    return leadsTo(other, file) ? `${source} imports this file: a circle` : "";
  return floorOf(other) > floorOf(file) ? "" : `${roomOf(file)} is not above ${roomOf(other)} (rooms.js)`;
}

const downwards = {
  create(context) {
    const file = context.filename;
    const look = (node) => {
      const source = node.source?.value;
      const message = typeof source === "string" && source.startsWith(".") ? amissIn(file, source) : "";
      if (message !== "") context.report({ node, message });
    };
    return {
      ImportDeclaration: look,
      ImportExpression: look,
      ExportNamedDeclaration: look,
      ExportAllDeclaration: look,
      TSImportType: look,
    };
  },
};

checkList();

/** An ESLint configuration that keeps imports going down, without a circle. */
export default {
  files: ["src/**"],
  plugins: { rooms: { rules: { downwards } } },
  rules: { "rooms/downwards": "error" },
};
