"""A lens that zooms while its camera moves, told by depth, which a zoom leaves as it is; and its zoom undone.

A path that is sought with one focal length takes a zoom for a motion along the view, and what is left of it
for tissue that moves. Each of some views gets a focal length of its own (bundle.py), which is kept where
clearly less is left over then.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from renderer.camera import FloatArray, IntArray
from renderer.evenly import evenly
from renderer.poses.between import between
from renderer.poses.bundle import Bundle, FocalGuess, adjusted, cost_of, misfit
from renderer.poses.resection import FEWEST, TO_DEVIATION
from renderer.poses.tissue_motion import places_of
from renderer.poses.views import DEPTH_NOISE, PIXEL_NOISE, Rough, View, bundle_of

_LEFT = 0.965
"""Of the cost with one focal length, at most. Without a zoom it is 0.98 to 1 of phantoms at rest, pulled, and
that breathe (seeds 0 to 3, depth exact and off by 0.3 px)."""
_LEAST = 0.04
"""By which the image is larger somewhere, at least. Without a zoom, phantoms that breathe seem to zoom by up
to 2.4 %, and a real wall, whose depth is from eyes without calibration, by 3 % at 0.90 of that cost."""
_VIEWS = 20
_SEEN_BY = 3
"""Views of a point that may have a say."""
_FOCAL_SPREAD = 0.3
"""Of the logarithm of the focal length, where it is one: a wrong one is no zoom."""
_ROUNDS = 12
_LEAST_PX, _LEAST_DEPTH = 0.02, 1e-5


@dataclass(frozen=True, eq=False)
class Zoom:
    """How a focal length changes: evenly between the frames at which it is known."""

    frames: IntArray
    """(K,) of the clip, ascending."""
    longer: FloatArray
    """(K,) logarithm of how much longer it is there than where it is shortest. The clip's is taken for that:
    lenses are calibrated before they zoom."""

    def at(self, frame: int) -> float:
        return float(np.interp(frame, self.frames, self.longer))

    @property
    def grown(self) -> float:
        """Share by which the image is larger where it is largest; 0: it does not zoom."""
        return math.expm1(float(self.longer.max()))

    @property
    def ends(self) -> tuple[int, int]:
        """The frames at which the image is smallest and largest."""
        return int(self.frames[self.longer.argmin()]), int(self.frames[self.longer.argmax()])


ONE_LENS: Final = Zoom(np.zeros(1, np.int64), np.zeros(1))
"""It does not zoom."""


def zoom_undone(rough: Rough) -> tuple[Zoom, Rough]:
    """How the lens of views with depth zooms, and what one that does not would show; ONE_LENS and the very
    same views where no zoom is seen."""
    places = evenly(range(len(rough.views)), min(_VIEWS, len(rough.views)))
    one = _with_one_lens(rough, [rough.views[place] for place in places])
    if one is None:
        return ONE_LENS, rough
    many, longer = _with_zooms(one)
    if _cost(many) > _LEFT * _cost(one) or math.expm1(np.ptp(longer)) < _LEAST:
        return ONE_LENS, rough
    many, longer = _with_zooms(replace(many, lens=rough.lens, focal=None))
    zoom = Zoom(np.array([rough.views[place].frame for place in places]), longer - longer.min())
    return zoom, _undone(rough, zoom, dict(zip(places, many.poses, strict=True)))


def _with_one_lens(rough: Rough, views: Sequence[View]) -> Bundle | None:
    """None: there is no depth, or too few points are seen often."""
    whole = bundle_of(rough.lens, views, rough.points, FocalGuess(rough.lens.fx, _FOCAL_SPREAD))
    held = np.bincount(whole.seen_points, minlength=len(rough.points))[whole.seen_points] >= _SEEN_BY
    kept, ids = np.unique(whole.seen_points[held], return_inverse=True)
    measured, weights = whole.seen.measured[held], whole.seen.weights[held]
    if len(kept) < FEWEST or not (weights[:, 2] > 0).any():
        return None
    seen = replace(whole.seen, measured=measured, weights=weights)
    bundle = replace(whole, points=rough.points[kept], views=whole.views[held], seen_points=ids, seen=seen)
    bundle = adjusted(_weighed(bundle, PIXEL_NOISE, DEPTH_NOISE), _ROUNDS)
    bundle = adjusted(_weighed(bundle, *_noise(bundle)), _ROUNDS)
    return adjusted(_weighed(bundle, *_noise(bundle)), _ROUNDS)


def _with_zooms(bundle: Bundle) -> tuple[Bundle, FloatArray]:
    """And how much longer the focal lengths are (K,), see Bundle."""
    start = np.zeros(len(bundle.poses)) if bundle.longer is None else bundle.longer
    found = adjusted(replace(bundle, longer=start), 2 * _ROUNDS)
    assert found.longer is not None
    return found, found.longer


def _cost(bundle: Bundle) -> float:
    return cost_of(bundle, misfit(bundle))


def _noise(bundle: Bundle) -> tuple[float, float]:
    """Standard deviations of most places, in px, and inverse depths."""
    known = bundle.seen.weights > 0
    off = np.abs(misfit(bundle)) / np.where(known, bundle.seen.weights, 1)
    pixel, depth = float(np.median(off[:, :2])), float(np.median(off[known[:, 2], 2]))
    return max(TO_DEVIATION * pixel, _LEAST_PX), max(TO_DEVIATION * depth, _LEAST_DEPTH)


def _weighed(bundle: Bundle, pixel: float, depth: float) -> Bundle:
    each = 1 / np.array([pixel, pixel, depth])
    return replace(bundle, seen=replace(bundle.seen, weights=np.where(bundle.seen.weights > 0, each, 0.0)))


def _undone(rough: Rough, zoom: Zoom, poses: Mapping[int, FloatArray]) -> Rough:
    """`poses` (4, 4): of some views, by their number, the first and the last among them."""
    views = tuple(
        replace(_shrunk(rough, view, zoom), pose=poses[at] if at in poses else between(poses, at))
        for at, view in enumerate(rough.views)
    )
    return replace(rough, views=views, points=places_of(rough.lens, views, rough.points))


def _shrunk(rough: Rough, view: View, zoom: Zoom) -> View:
    middle = np.array([rough.lens.cx, rough.lens.cy])
    measured = view.seen.measured.copy()
    measured[:, :2] = middle + (measured[:, :2] - middle) * math.exp(-zoom.at(view.frame))
    return replace(view, seen=replace(view.seen, measured=measured), inliers=np.ones(len(view.ids), bool))
