import type { RigInfo } from "../api/types";
import { kilopascals, millimetres, plain } from "../ui/format";

type Actuator = RigInfo["parameters"]["actuator"];

const GRAM = 1e3;

/** What is said about an actuator: name and value of each fact. */
export function actuatorFacts(actuator: Actuator): [string, string][] {
  const { name, length, width, height, mass, u_max, pressure_max, tip_load, k } = actuator;
  const facts: [string, string][] = [
    ["Name", name],
    ["Length", millimetres(length, 0)],
    ["Width × height", `${plain(width * 1e3, 1)} × ${millimetres(height)}`],
    ["Mass", `${plain(mass * GRAM, 0)} g`],
    ["Joint stiffness", `${range(k)} N m/rad`],
    ["Torque limit", `${plain(u_max * 1e3, 0)} mN m`],
    ["Highest pressure", kilopascals(pressure_max)],
  ];
  if (tip_load > 0) facts.push(["Tip load", `${plain(tip_load * GRAM, 0)} g`]);
  return facts;
}

/** A profile as one number, or from its lowest to its highest. */
function range(profile: readonly number[]): string {
  const [low, high] = [Math.min(...profile), Math.max(...profile)].map((value) => value.toPrecision(3));
  return low === high ? low : `${low} … ${high}`;
}
