"""Morphological opening by a disc: what is narrower and brighter than its surroundings goes."""

from __future__ import annotations

import cv2
import numpy as np

from enhance.image import Float32Image


def opening(plane: Float32Image, radius: int) -> Float32Image:
    """(H, W) opened by a disc of `radius` pixels, at a size that leaves it 8 to 16 pixels, and smoothed."""
    step = max(1, radius // 8)
    height, width = plane.shape
    small_size = (-(-width // step), -(-height // step))
    small = cv2.resize(plane, small_size, interpolation=cv2.INTER_AREA)
    reach = max(1, radius // step)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    opened = cv2.morphologyEx(small, cv2.MORPH_OPEN, disc, borderType=cv2.BORDER_REPLICATE)
    calm = cv2.GaussianBlur(opened, (0, 0), 0.6)
    return np.asarray(cv2.resize(calm, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)
