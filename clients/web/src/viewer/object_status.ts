// How running sensors see an object, in words and as marks of the picture. Pure.
import { Color } from "three";
import { shortName, type WorldObject } from "../world/types";

type Facts = Pick<WorldObject, "motion" | "visibility" | "state">;

const known = (value: string, type: string): string => {
  const short = shortName(value, type);
  return short === "unspecified" ? "" : short.replaceAll("_", " ");
};

export const motionWord = ({ motion }: Facts): string => known(motion, "MOTION");

export const visibilityWord = ({ visibility }: Facts): string => known(visibility, "VISIBILITY");

// The words worth a mark in a list: nothing for an object that is seen at rest. Without a running
// sensor, the state that scans left.
export function statusText(object: Facts): string {
  const motion = motionWord(object);
  const visibility = visibilityWord(object);
  if (motion === "" && visibility === "") {
    const state = shortName(object.state, "OBJECT_STATE");
    return state === "occluded" || state === "lost" ? state : "";
  }
  return [motion === "at rest" ? "" : motion, visibility === "visible" ? "" : visibility].filter((word) => word !== "").join(", ");
}

// An object that is out of sight keeps its shape and its colour's hue.
const dimColor = new Color("#b4bac3");
const dimShare = 0.55;

export const isDimmed = (object: Facts): boolean => ["occluded", "lost"].includes(visibilityWord(object));

export const dimmed = (color: string): string => `#${new Color(color).lerp(dimColor, dimShare).getHexString()}`;

// Nobody knows whether it is still there.
export const isStriped = (object: Facts): boolean => ["stale", "lost"].includes(visibilityWord(object));
