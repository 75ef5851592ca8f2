// Rows of a robot's joints: of states that its SRDF names, and between two rows. Pure.
import type { Robot, RobotVariable } from "../world/stream";
import { QueryError } from "./query_words";

// The variables of a row: of the group, or without one of the robot.
function variablesOf({ variables, groups }: Robot, group: string): RobotVariable[] {
  const found = groups.find(({ name }) => name === group);
  if (!found) return [...variables];
  return found.joints.flatMap((joint) => variables.filter((variable) => variable.joint === joint));
}

// The row of a named state. Joints that the state does not name keep their present values. Throws a
// QueryError.
export function stateRow(robot: Robot | undefined, robotName: string, group: string, state: string): number[] {
  if (!robot) throw new QueryError(`joints: there is no robot "${robotName}" in this world`);
  if (group !== "" && !robot.groups.some(({ name }) => name === group)) {
    const known = robot.groups.map(({ name }) => name).join(", ");
    throw new QueryError(`group: "${robotName}" has no group "${group}"${known === "" ? "" : `: ${known}`}`);
  }
  const of = robot.groups.filter(({ name }) => group === "" || name === group);
  const found = of.flatMap(({ name, states }) => states.filter((one) => one.name === state).map((one) => ({ name, values: one.values })));
  if (found.length > 1) {
    throw new QueryError(`joints: "${state}" is a state of ${found.map(({ name }) => name).join(" and ")}: say which with group`);
  }
  const [one] = found;
  if (!one) {
    const known = of.flatMap(({ states }) => states.map(({ name }) => name));
    throw new QueryError(`joints: "${state}" must be numbers, one for each joint, or a named state` +
                         (known.length === 0 ? ", of which there are none" : `: ${known.join(", ")}`));
  }
  const values = new Map(one.values.map(({ variable, value }) => [variable, value]));
  return variablesOf(robot, group).map((variable) =>
    values.get(variable.name) ?? robot.state[robot.variables.indexOf(variable)] ?? 0);
}

// The row at a share of the way from one to another, continuous joints the short way.
export function rowBetween(robot: Robot, group: string, from: readonly number[], to: readonly number[], share: number): number[] {
  const variables = variablesOf(robot, group);
  return from.map((value, i) => {
    const whole = (to[i] ?? value) - value;
    const isContinuous = variables[i]?.joint_kind === "JOINT_KIND_CONTINUOUS";
    const way = isContinuous ? whole - 2 * Math.PI * Math.round(whole / (2 * Math.PI)) : whole;
    return value + share * way;
  });
}
