"""A depth camera before a table with a ball and a box, simulated: an organised cloud for the
examples.
"""

from __future__ import annotations

import numpy as np

BALL_CENTER, BALL_RADIUS_M = np.array([0.05, 0.18, 0.07]), 0.07
BOX_CENTER, BOX_SIZE_M = np.array([0.1, -0.15, 0.06]), np.array([0.12, 0.16, 0.12])
TABLE_HALF_M = np.array([0.5, 0.45])


def camera_pose() -> np.ndarray:
    """X_WS, (4, 4): z looks down at the table from behind it, x to the right, y down in the
    picture.
    """
    eye, target = np.array([-0.8, 0.0, 0.7]), np.array([0.05, 0.0, 0.0])
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(ahead, right), ahead])
    pose[:3, 3] = eye
    return pose


def _table_m(eye: np.ndarray, rays: np.ndarray) -> np.ndarray:
    t = -eye[2] / rays[..., 2]
    on_table = (np.abs((eye + t[..., None] * rays)[..., :2]) < TABLE_HALF_M).all(axis=-1)
    return np.where((t > 0) & on_table, t, np.inf)


def _ball_m(eye: np.ndarray, rays: np.ndarray) -> np.ndarray:
    b = rays @ (eye - BALL_CENTER)
    inside = b**2 - (np.sum((eye - BALL_CENTER) ** 2) - BALL_RADIUS_M**2)
    return np.where(inside > 0, -b - np.sqrt(np.maximum(inside, 0)), np.inf)


def _box_m(eye: np.ndarray, rays: np.ndarray) -> np.ndarray:
    low = (BOX_CENTER - BOX_SIZE_M / 2 - eye) / rays
    high = (BOX_CENTER + BOX_SIZE_M / 2 - eye) / rays
    enter, leave = np.minimum(low, high).max(axis=-1), np.maximum(low, high).min(axis=-1)
    return np.where((enter < leave) & (enter > 0), enter, np.inf)


def table_scan(width: int = 320, height: int = 240, seed: int = 1) -> np.ndarray:
    """(height, width, 3) float32 in the sensor's frame; NaN where the camera sees nothing."""
    u, v = np.meshgrid(np.arange(width) - (width - 1) / 2, np.arange(height) - (height - 1) / 2)
    seen = np.dstack([u, v, np.full(u.shape, 0.82 * width)])  # a focal length as of a Kinect
    seen /= np.linalg.norm(seen, axis=-1, keepdims=True)
    pose = camera_pose()
    rays, eye = seen @ pose[:3, :3].T, pose[:3, 3]
    range_m = np.minimum.reduce([_table_m(eye, rays), _ball_m(eye, rays), _box_m(eye, rays)])
    depth_m = range_m * seen[..., 2]
    noise_m = 0.0012 + 0.0019 * (np.where(np.isfinite(depth_m), depth_m, 0) - 0.4) ** 2
    with np.errstate(invalid="ignore"):
        scale = 1 + np.random.default_rng(seed).normal(size=range_m.shape) * noise_m / depth_m
        points = seen * (range_m * scale)[..., None]
    points[~np.isfinite(range_m)] = np.nan
    return points.astype(np.float32)
