"""The black surround of a round endoscope picture, which says nothing about tissue."""

from __future__ import annotations

import cv2
import numpy as np

from renderer.clip import BoolImage, ByteImage

BLACK = 24
"""Grey levels: V below it is black, camera noise and compression included."""
LEAST_SHARE = 0.01
"""Of the picture: smaller dark corners are shadow."""
RIM = 2
"""Pixels next to the surround that are half dark."""


def inside(image: ByteImage) -> BoolImage:
    """(H, W) True = picture, False = the black that touches the border of an (H, W, 3) image."""
    value = cv2.medianBlur(image.max(axis=2), 5)
    dark = (value < BLACK).astype(np.uint8)
    _, labels, facts, _ = cv2.connectedComponentsWithStats(dark, connectivity=4)
    border = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    large = np.flatnonzero(facts[:, cv2.CC_STAT_AREA] >= LEAST_SHARE * dark.size)
    outer = np.intersect1d(np.setdiff1d(border, [0]), large)
    outside = np.isin(labels, outer).astype(np.uint8)
    kernel = np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)
    return np.asarray(cv2.dilate(outside, kernel) == 0)
