"""Poses. A user has 4 x 4 matrices; the wire has rows tx ty tz qx qy qz qw (metres, unit
quaternion).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cwm import arrays
from cwm.v1 import geometry_pb2

# The tolerance of R'R against the identity and of a quaternion's length against 1, which is the
# server's for quaternions.
_TOLERANCE = 1e-3


def pose(
    position: npt.ArrayLike = (0, 0, 0), quaternion: npt.ArrayLike = (0, 0, 0, 1)
) -> np.ndarray:
    """A (4, 4) pose of a position (3,) in metres and a unit quaternion x, y, z, w (4,)."""
    row = np.concatenate(
        [arrays.vector(position, "position"), arrays.vector(quaternion, "quaternion", 4)]
    )
    return to_matrices(to_rows(row, "quaternion"))[0]


def to_matrices(rows: np.ndarray) -> np.ndarray:
    """(N, 7) rows with unit quaternions, which may be rounded, as (N, 4, 4) float64."""
    quaternions = rows[:, 3:].astype(np.float64)
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    matrices = np.zeros((len(rows), 4, 4))
    matrices[:, 0, 0] = 1 - 2 * (y * y + z * z)
    matrices[:, 0, 1] = 2 * (x * y - z * w)
    matrices[:, 0, 2] = 2 * (x * z + y * w)
    matrices[:, 1, 0] = 2 * (x * y + z * w)
    matrices[:, 1, 1] = 1 - 2 * (x * x + z * z)
    matrices[:, 1, 2] = 2 * (y * z - x * w)
    matrices[:, 2, 0] = 2 * (x * z - y * w)
    matrices[:, 2, 1] = 2 * (y * z + x * w)
    matrices[:, 2, 2] = 1 - 2 * (x * x + y * y)
    matrices[:, :3, 3] = rows[:, :3]
    matrices[:, 3, 3] = 1
    return matrices


def _quaternions(rotations: np.ndarray) -> np.ndarray:
    """(N, 3, 3) rotations as (N, 4) x y z w, by the largest component of each: no cancellation."""
    r = rotations
    trace = np.trace(r, axis1=1, axis2=2)
    diagonal = np.diagonal(r, axis1=1, axis2=2)
    squares = np.column_stack(
        [1 + 2 * diagonal - trace[:, None], 1 + trace]
    )  # 4 x^2, 4 y^2, 4 z^2, 4 w^2
    products = np.empty((len(r), 4, 4))  # 4 q q'
    products[:, range(4), range(4)] = squares
    for i, j in ((0, 1), (0, 2), (1, 2)):
        products[:, i, j] = products[:, j, i] = r[:, i, j] + r[:, j, i]
    for i, (j, k) in enumerate(((2, 1), (0, 2), (1, 0))):
        products[:, i, 3] = products[:, 3, i] = r[:, j, k] - r[:, k, j]
    largest = np.argmax(squares, axis=1)
    quaternions = products[np.arange(len(r)), largest]
    return quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)


def _check_matrices(matrices: np.ndarray, name: str) -> None:
    rotations = matrices[:, :3, :3].astype(np.float64)
    off = np.abs(np.einsum("nji,njk->nik", rotations, rotations) - np.eye(3)).max(axis=(1, 2))
    bottom = np.abs(matrices[:, 3, :] - [0, 0, 0, 1]).max(axis=1)
    bad = np.flatnonzero(
        (off > _TOLERANCE) | (bottom > _TOLERANCE) | (np.linalg.det(rotations) < 0)
    )
    if bad.size:
        raise ValueError(
            f"{name}[{bad[0]}] is no pose: must have an orthonormal, right-handed 3 x 3 block "
            "and the last row 0 0 0 1"
        )


def to_rows(value: npt.ArrayLike, name: str) -> np.ndarray:
    """Poses as the wire has them, (N, 7), in the precision given; of (N, 4, 4), (4, 4), (N, 7) or
    (7,).

    ValueError for other shapes, an empty array, numbers that are not finite, and what is no rigid
    transform.
    """
    array = arrays.numbers(value, name)
    if array.ndim in (1, 2) and array.shape != (4, 4):
        if array.shape[-1:] != (7,) or array.size == 0:
            raise ValueError(
                f"{name} has the shape {array.shape}, must be (N, 4, 4) or (N, 7), at least one"
            )
        rows = arrays.rows(array, name, 7)
        lengths = np.linalg.norm(rows[:, 3:], axis=1)
        bad = np.flatnonzero(np.abs(lengths - 1) > _TOLERANCE)
        if bad.size:
            raise ValueError(
                f"{name}[{bad[0]}] has a quaternion of length {lengths[bad[0]]:.6g}, must be 1"
            )
        return rows
    matrices = array.reshape(1, 4, 4) if array.shape == (4, 4) else array
    if matrices.ndim != 3 or matrices.shape[1:] != (4, 4) or matrices.size == 0:
        raise ValueError(
            f"{name} has the shape {array.shape}, must be (N, 4, 4) or (N, 7), at least one"
        )
    arrays.finite(matrices, name)
    _check_matrices(matrices, name)
    rows = np.empty((len(matrices), 7), dtype=matrices.dtype)
    rows[:, :3] = matrices[:, :3, 3]
    rows[:, 3:] = _quaternions(matrices[:, :3, :3].astype(np.float64))
    return rows


def to_proto(value: npt.ArrayLike, name: str) -> geometry_pb2.Pose:
    """One pose, (4, 4) or (7,)."""
    rows = to_rows(value, name)
    if len(rows) != 1:
        raise ValueError(f"{name} has {len(rows)} poses, must be one, (4, 4) or (7,)")
    row = rows[0].astype(np.float64).tolist()
    return geometry_pb2.Pose(
        tx_m=row[0], ty_m=row[1], tz_m=row[2], qx=row[3], qy=row[4], qz=row[5], qw=row[6]
    )


def from_proto(message: geometry_pb2.Pose) -> np.ndarray:
    """(4, 4); read-only, as it is part of an answer."""
    row = np.array(
        [[message.tx_m, message.ty_m, message.tz_m, message.qx, message.qy, message.qz, message.qw]]
    )
    if not row[0, 3:].any():
        row[0, 6] = 1  # an absent pose is the identity
    matrix = to_matrices(row)[0]
    matrix.flags.writeable = False
    return matrix
