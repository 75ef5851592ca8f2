// The classes of a frame's pixels, in the colours of the live points and of their legend.
import type { PixelCounts } from "../world/stream";

export interface PixelClass {
  key: keyof PixelCounts;
  color: string;
  meaning: string;
}

// Unmodelled movers, too, have the colour of what is nearer than expected: that is how they are found.
export const nearerColor = "#d81b60";

// In the order of the enum PixelClass from 1. Chosen to be told apart by every kind of colour vision
// together with their brightness: what is as expected is pale, what differs is strong.
export const pixelClasses: readonly PixelClass[] = [
  { key: "consistent", color: "#9aa3ae", meaning: "as the known world is expected to look" },
  { key: "nearer", color: nearerColor, meaning: "before what is known" },
  { key: "farther", color: "#1e88e5", meaning: "the ray passed through what is known" },
  { key: "missing", color: "#000000", meaning: "no return, so that there is no point" },
  { key: "robot", color: "#7e57c2", meaning: "the robot" },
  { key: "carried", color: "#00a08a", meaning: "what the robot carries" },
  { key: "mixed", color: "#c9a100", meaning: "at the outline of the robot: neither geometry nor free space" },
  { key: "hidden", color: "#8d6e63", meaning: "a known surface behind the robot or a mover" },
];

export const sumOf = (counts: PixelCounts): number => pixelClasses.reduce((sum, { key }) => sum + Number(counts[key]), 0);
