"""What curves in time do while tissue is hidden: as little as what was seen allows.

Control values that act only while a tool hides the tissue meet hardly any gradient, and Adam, which divides
by the gradient's own size, lets them drift: a viewer who looks behind the tool sees coloured specks. After
training each curve f is replaced by the curve g that minimises

    sum over training frames t of v(t) (g(t) - f(t))^2
    + SLACK * sum over k of (1 - min(s_k, s_(k-1)))^2 (g_k - g_(k-1))^2
    + REST * sum over k of (1 - s_k)^2 (g_k - r)^2, of colours alone

with v the share to which frame t saw the Gaussian and s_k that of the frames near control value k, so that a
curve stays what it is wherever it was seen. At rest a Gaussian has the colour that it was made with, that of
a pixel of some frame (r = 0): noise that few looks left does not last. Places have no such pull, which would
bring what has left the view, or lies behind other tissue, back into sight.

Where that pixel lay in a highlight, so would the Gaussian for good, wherever its tissue moves to while no
frame shows it; but what shines is the light's and not the tissue's. So r takes it to within GLARE of the
median of its neighbours. On training frames of pulling that were held out (1200 steps, seed 0): 8.25 pixels
of specks a frame without, 0.38 with it, 38.867 and 38.876 dB, 38.75 and 38.74 of what is seldom seen; as many
specks with a GLARE of 0.04, and 38.73 dB of the latter. With the mean of the colours that frames saw in place
of that of one pixel there are 25, and with a REST of 0.03, 0.04 dB of all are lost.

Pixels beside a tool are in part of its colour, and what is hidden was last seen there: a curve of colour that
they hold shows a ghost of the tool. For colours, pixels within EDGE of the mask count BESIDE as much in v.

Where a frame sees a sliver of a Gaussian alone, its colour is what suits the sliver: of long ones that lie
along the edge of what is ever seen, black or bright needles are left behind the tool. So frames that see
about SLIVER of it, or less, tell little of its colour; its place they tell, without which 0.5 dB of what is
seldom seen are lost. On training frames of pulling that were held out (3000 steps, seed 0), with the shreds
of fading.py: 2.4 pixels of specks a frame without, 1.0 with it, 39.347 and 39.345 dB, 39.48 and 39.43 of what
is seldom seen; as many specks and 39.342 dB with 0.05.

What shows through other tissue alone, by a few per cent of it, takes any colour that helps there: white,
black or green, and a view from beside shows it bare. So colours are first sought as if those frames alone
counted that see about CLEARLY of what a Gaussian covers, or more; at those it then rests, and where others
saw it, its own colour stays, to within LEAK of them. On training frames that were held out (3000 steps, seed
0), without and with it: mesentery 37.467 and 37.454 dB, 40.27 and 40.39 of what is seldom seen, 0.5 and 0.8
pixels of specks; pulling 39.342 and 39.346, 39.50 and 39.54, 0.4 each; pixels that glare in views from 15
degrees aside, highlights among them, 987 and 723, 840 and 847. Without SLACK at rest a LEAK of 0.2 leaves
683 for 717 and costs 0.04 dB.

A highlight that lay on tissue as a tool came over it goes on for some frames by its curve, and long Gaussians
smear it along the edge of what is ever seen. So where a Gaussian is hidden its colour differs by STRAY at
most from the median of its neighbours' at that time. On training frames that were held out (3000 steps, seed
0), without and with it: mesentery 37.454 and 37.508 dB, 40.39 each of what is seldom seen, 0.75 and 0 pixels
of specks a frame; pulling 39.346 and 39.355, 39.54 and 39.56, 0 each. What shows through other tissue counts
as hidden in part: with a FREE of 1 mesentery has 37.423 dB. Where colours alone tell what is seen, it loses
0.38 dB of what is seldom seen.

SLACK and SEEN were chosen on training frames of the pulling clip (1500 steps, seed 0). Behind two made-up
masks, and on visible tissue of frames held out: 24.4 and 27.7 dB, and 38.60, without; 25.3 and 29.0, 38.48
with SLACK of 0.01 and SEEN of 0.1; 26.1 and 30.3, 38.52 with SEEN of 0.5 and REST of 0.03 and no EDGE.
The others were chosen on training frames with two made-up tools in the image, whose edges are soft (1000
steps), and on the phantom (1500). Behind the tools and visible, without EDGE: pulling 22.3 and 36.63 dB,
mesentery 23.5 and 36.06, phantom 24.4 and 42.71; with it 25.0 and 36.63, 23.6 and 36.06, 27.0 and 42.54.
BESIDE of 0 gives 26.6 and 36.59, 28.7 and 42.00; EDGE of 3 and BESIDE of 0 for places, too, is no better.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from renderer.deformation.spline import spline_taps
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import Rasterizer
from renderer.rasterize.footprints import footprints
from renderer.raw_gaussians import RawGaussians
from renderer.splats import RenderMode
from renderer.train.events import Omission
from renderer.train.frames import TrainFrame, away_from_tools
from renderer.train.neighbours import nearest_others

SLACK = 0.01
REST = 0.01
EDGE = 6.0
"""Pixels beside tools whose colour counts less."""
BESIDE = 0.01
"""Of what others count; not nothing, for what is never seen elsewhere."""
SEEN = np.float32(0.5)
"""Blending weight over all supervised pixels by which a frame saw a Gaussian to one half."""
SLIVER = np.float32(0.02)
"""Share of a Gaussian in supervised pixels that tells half as much of its colour as all of it does."""
CLEARLY = np.float32(0.2)
"""Share of what a Gaussian covers, not hidden by others, by which a frame sees half of its colour."""
LEAK = np.float32(0.3)
"""Of 1, by which colours that no frame sees clearly differ at most from those that some do."""
AROUND = 31
"""Neighbours whose colours tell what lies about a Gaussian: more than a highlight takes."""
GLARE = np.float32(0.08)
"""By which, of 1, its colour at rest differs from theirs at most: two that differ to both sides are close."""
STRAY, FREE = np.float32(0.04), np.float32(3.0)
"""By which, of 1, a colour differs at most from theirs at a time when no frame sees it, and by how much more
times the share of the frames that do: a third of them tell of any colour."""
BATCH = 8192
"""Control values for which neighbours are looked at at once."""
TINY = np.float32(1e-12)
_RIDGE = 1e-9
"""Of curves that no frame saw: they rest."""
_BAND = 4
_HIDDEN = 0.01
"""Seen to a smaller share than this is said to be hidden."""


def smooth_occluded_motion(
    gaussians: DynamicGaussians, frames: Sequence[TrainFrame], near: float, mode: RenderMode = "default"
) -> tuple[DynamicGaussians, tuple[Omission, ...]]:
    """The model with splines at rest where none of the frames, of one size, saw them; what was left out."""
    motion = gaussians.motion
    if not isinstance(motion, SplineMotion):
        return gaussians, ()
    n_nodes, n_controls = len(motion.node_controls), motion.n_controls
    normal, normal_colors, normal_clear = (np.zeros((len(gaussians), n_controls, _BAND)) for _ in range(3))
    normal_nodes = np.zeros((n_nodes, n_controls, _BAND))
    normal_whole = np.zeros((1, n_controls, _BAND))
    for frame, (seen, apart, clear) in zip(frames, _seen_shares(gaussians, frames, near, mode), strict=True):
        taps = spline_taps(frame.time, n_controls)
        _add_normal(normal, seen, *taps)
        _add_normal(normal_colors, apart, *taps)
        _add_normal(normal_clear, clear, *taps)
        _add_normal(normal_nodes, _seen_of_nodes(motion, seen), *taps)
        _add_normal(normal_whole, np.ones(1, np.float32), *taps)
    whole = normal_whole[0, :, 0]
    share = float(np.mean(normal[:, :, 0] < _HIDDEN * whole))
    if share == 0:
        return gaussians, ()
    _, others = nearest_others(gaussians.raw.means, AROUND)
    resting = _steps_from_glare(gaussians.raw, motion, others)
    colors = _colors_at_rest(motion.color_controls, resting, normal_clear, normal_colors, whole)
    seen_then = (normal[:, :, 0] / np.maximum(whole, TINY)).astype(np.float32)
    still = replace(
        motion,
        position_controls=_at_rest(motion.position_controls, normal, whole),
        color_controls=_colors_like_others(colors, gaussians.raw, others, seen_then),
        opacity_controls=_at_rest(motion.opacity_controls, normal, whole),
        node_controls=_at_rest(motion.node_controls, normal_nodes, whole),
    )
    saves = f"{100 * share:.1f} % of the control values"
    omission = Omission("motion of hidden tissue", "no training frame shows it", saves, "hidden")
    return replace(gaussians, motion=still), (omission,)


def _at_rest(
    curves: NDArray[np.float32], normal: NDArray[np.float64], whole: NDArray[np.float64], rest: float = 0.0
) -> NDArray[np.float32]:
    out = curves.copy()
    if out.size:
        _solve(normal, whole, SLACK, rest, out)
    return out


def _colors_at_rest(
    curves: NDArray[np.float32],  # (N, K, 3)
    resting: NDArray[np.float32],  # (N, 1, 3)
    clear: NDArray[np.float64],  # (N, K, BAND) of frames that see a Gaussian clearly
    seen: NDArray[np.float64],  # (N, K, BAND) of those that see it at all
    whole: NDArray[np.float64],
) -> NDArray[np.float32]:
    clearly = _at_rest(curves - resting, clear, whole, REST) + resting
    besides = _at_rest(curves - clearly, seen, whole, REST)
    return clearly + np.clip(besides, -LEAK, LEAK)


def _steps_from_glare(
    raw: RawGaussians, motion: SplineMotion, others: NDArray[np.int64]
) -> NDArray[np.float32]:
    """(N, 1, 3) from colours that Gaussians were made with to those at rest; none without curves."""
    if not len(motion.color_controls):
        return np.zeros((0, 1, 3), np.float32)
    around = np.median(raw.colors[others], axis=1) if others.size else raw.colors
    return (np.clip(raw.colors, around - GLARE, around + GLARE) - raw.colors)[:, None]


def _colors_like_others(
    curves: NDArray[np.float32],  # (N, K, 3)
    raw: RawGaussians,
    others: NDArray[np.int64],  # (N, AROUND), or fewer
    seen: NDArray[np.float32],  # (N, K) share of the frames near each control value that see a Gaussian
) -> NDArray[np.float32]:
    if not (len(curves) and others.size):
        return curves
    colors, out = raw.colors[:, None] + curves, curves.copy()
    reach = STRAY + FREE * seen
    bound = np.argwhere(reach < 1)
    for begin in range(0, len(bound), BATCH):
        rows, at = bound[begin : begin + BATCH].T
        around = np.median(colors[others[rows], at[:, None]], axis=1)
        most, found = reach[rows, at, None], colors[rows, at]
        out[rows, at] += np.clip(found, around - most, around + most) - found
    return out


def _seen_of_nodes(motion: SplineMotion, seen: NDArray[np.float32]) -> NDArray[np.float32]:
    """(M,) to which share a frame saw each node, by the Gaussians that it moves."""
    by_node = np.zeros(len(motion.node_controls), np.float32)
    if len(motion.node_indices):
        np.add.at(by_node, motion.node_indices, motion.node_weights**2 * seen[:, None])
    return np.minimum(by_node, np.float32(1.0))


def _seen_shares(
    gaussians: DynamicGaussians, frames: Sequence[TrainFrame], near: float, mode: RenderMode = "default"
) -> Iterator[tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]]:
    """Three times (N,) of each frame: w / (w + SEEN) of the blending weight w that supervised pixels give a
    Gaussian, and of its colour: those beside tools give less, and a sliver in sight tells hardly anything;
    and the same where other tissue does not hide it."""
    width, height = frames[0].camera.width, frames[0].camera.height
    rasterizer = Rasterizer(width, height)
    for frame in frames:
        rasterizer.forward(gaussians.at(frame.time), frame.camera, near, mode=mode)
        everywhere = np.ones(frame.color_mask.shape, np.float32)
        weight, apart, whole = rasterizer.blending_weights(frame.color_mask, _trusted(frame), everywhere)
        told = weight**2 / (weight**2 + (SLIVER * whole) ** 2 + TINY)
        colored = told * apart / (apart + SEEN)
        bare = np.zeros(len(whole), np.float32)
        visible = np.flatnonzero(rasterizer.visible)
        covered = footprints(rasterizer.records[visible], width, height)
        bare[visible] = whole[visible] / np.maximum(covered, TINY)
        yield weight / (weight + SEEN), colored, colored * bare**4 / (bare**4 + CLEARLY**4)


def _trusted(frame: TrainFrame) -> NDArray[np.float32]:
    """(H, W) how much the colour of a pixel counts, from 0 to 1; the image's own border is no edge."""
    height, width = frame.camera.height, frame.camera.width
    away = away_from_tools(frame.color_mask[:height, :width])
    trusted = np.zeros(frame.color_mask.shape, np.float32)
    trusted[:height, :width] = np.where(away > EDGE, np.float32(1), np.float32(BESIDE)) * (away > 0)
    return trusted


@njit(parallel=True, cache=True)
def _add_normal(
    normal: NDArray[np.float64],  # (N, K, BAND), added to: upper band of the symmetric matrix of each curve
    seen: NDArray[np.float32],  # (N,)
    first: int,
    weights: NDArray[np.float32],  # (4,)
) -> None:
    for n in prange(len(normal)):
        for i in range(4):
            for j in range(i, 4):
                normal[n, first + i, j - i] += seen[n] * np.float64(weights[i]) * np.float64(weights[j])


@njit(parallel=True, cache=True, error_model="numpy")
def _solve(
    normal: NDArray[np.float64],  # (N, K, BAND)
    whole: NDArray[np.float64],  # (K,) its diagonal where every frame sees all
    slack: float,
    rest: float,
    curves: NDArray[np.float32],  # (N, K, C), replaced
) -> None:
    """Each curve's minimiser, by the factors L D L^T of its banded matrix."""
    count, n_controls, channels = curves.shape
    for n in prange(count):
        matrix = normal[n].copy()
        right = np.zeros((n_controls, channels))
        for k in range(n_controls):
            for j in range(min(_BAND, n_controls - k)):
                for c in range(channels):
                    right[k, c] += matrix[k, j] * curves[n, k + j, c]
                    if j > 0:
                        right[k + j, c] += matrix[k, j] * curves[n, k, c]
        for k in range(n_controls):
            here = normal[n, k, 0] / whole[k] if whole[k] > 0.0 else 0.0
            matrix[k, 0] += rest * (1.0 - here) ** 2 + _RIDGE
            if k < n_controls - 1:
                ahead = normal[n, k + 1, 0] / whole[k + 1] if whole[k + 1] > 0.0 else 0.0
                pull = slack * (1.0 - min(here, ahead)) ** 2
                matrix[k, 0] += pull
                matrix[k, 1] -= pull
                matrix[k + 1, 0] += pull
        for k in range(n_controls):
            for i in range(1, min(_BAND, n_controls - k)):
                share = matrix[k, i] / matrix[k, 0]
                for j in range(i, min(_BAND, n_controls - k)):
                    matrix[k + i, j - i] -= share * matrix[k, j]
                for c in range(channels):
                    right[k + i, c] -= share * right[k, c]
        for k in range(n_controls - 1, -1, -1):
            for c in range(channels):
                value = right[k, c]
                for j in range(1, min(_BAND, n_controls - k)):
                    value -= matrix[k, j] * right[k + j, c]
                right[k, c] = value / matrix[k, 0]
                curves[n, k, c] = right[k, c]
