// Poses of the API as matrices of three.js.
import { Matrix4, Quaternion, Vector3 } from "three";
import type { Pose } from "../world/types";

// An absent pose is the identity.
export function matrixOf(pose: Pose | undefined): Matrix4 {
  const matrix = new Matrix4();
  if (pose === undefined) return matrix;
  return matrix.compose(
    new Vector3(pose.tx_m, pose.ty_m, pose.tz_m),
    new Quaternion(pose.qx, pose.qy, pose.qz, pose.qw).normalize(),
    new Vector3(1, 1, 1));
}
