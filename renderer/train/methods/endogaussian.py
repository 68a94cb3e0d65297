"""`endogaussian` (Liu et al. 2024): Gaussians at rest first, then a HexPlane with small heads moves them.

Departures:

* 16 channels in place of 64 at each level: 19 million numbers in place of 85, and fewer for few Gaussians;
* time spans the whole grid, of as many rows as the published one uses half of;
* cells rest where they have no gradient; the rate of rows in time makes up for it;
* one schedule of rates over the steps at rest and those with motion, and moments that last; published: both
  begin anew with motion;
* depth is expected depth, moves Gaussians along the view; published: not divided by alpha, no gradient to z;
* depth is supervised as it is read, where it is measured alone; published: each frame's is clipped to its 3rd
  to 99.8th percentile, which takes unknown depth (0) for near tissue and supervises it;
* Gaussians are drawn once each; published: with replacement;
* spherical harmonics for a moving camera alone; every frame once an epoch; the box of the planes stays;
* no density control: published, it adds 2 % of Gaussians.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from renderer.clip import Frame
from renderer.deformation.heads import Heads
from renderer.deformation.hexplane import LANES, Layout
from renderer.deformation.hexplane_motion import HexplaneMotion
from renderer.raw_gaussians import RawGaussians
from renderer.train.config import TrainConfig
from renderer.train.hexplane_trainer import HexplaneRates, HexplaneTrainer
from renderer.train.initialize import round_gaussians, sampled
from renderer.train.losses import LossWeights
from renderer.train.methods.deform3dgs import MILLIMETRES
from renderer.train.needs import Needs
from renderer.train.neighbours import neighbour_distances
from renderer.train.rates import Rate, RowRates
from renderer.train.recipe import Recipe, Stage

RESOLUTIONS = (64, 128, 256, 512)
"""Cells of each level along x, y and z."""
CELLS = 3.0
"""Along x and y for each Gaussian, at most: finer levels than that are left out, all but the first."""
BLOCKS = 1
"""Of 16 channels."""
TIME_ROWS = 50
OPACITY = 0.1
COARSE_SHARE = 1 / 3
"""Steps at rest, beside those with motion: 1000 to 3000."""
SH_DC = 0.28209479
"""Colour that a spherical harmonic coefficient of degree 0 makes: its rate becomes one of colours."""


def recipe(config: TrainConfig, needs: Needs) -> Recipe:
    """Of the configuration only the steps with motion, the seed and the number of Gaussians matter."""
    coarse = round(config.iterations * COARSE_SHARE)
    steps = coarse + config.iterations

    def make_trainer(raw: RawGaussians, frames: Sequence[Frame], size: float) -> HexplaneTrainer:
        rates = HexplaneRates(cells=Rate(1.6e-2, 1.6e-4, steps), heads=Rate(1.6e-3, 1.6e-5, steps))
        return HexplaneTrainer(_motion(raw, size, np.random.default_rng([config.seed, 1])), rates)

    return Recipe(
        initialize=partial(_gaussians, config=config),
        make_trainer=make_trainer,
        rates=RowRates(
            means=Rate(1.6e-3 / MILLIMETRES, 1.6e-5 / MILLIMETRES, steps),
            quats=Rate.constant(1e-3),
            log_scales=Rate.constant(5e-3),
            opacity_logits=Rate.constant(5e-2),
            colors=Rate.constant(2.5e-3 * SH_DC),
            harmonics=Rate.constant(1.25e-4),
        ),
        stages=(Stage(coarse, moves=False, first_frame_only=True), Stage(config.iterations)),
        sh_degree=needs.sh_degree,
        losses=LossWeights(
            inverse_depth=1 / MILLIMETRES,
            image_variation=0.03,
            inverse_depth_variation=0.03 / MILLIMETRES,
        ),
    )


def _gaussians(frames: Sequence[Frame], config: TrainConfig) -> RawGaussians:
    """Sampled tissue, as large as the three nearest others are far; in order over the view, which is
    how their neighbours on the planes come from the processor's caches."""
    raw = sampled(frames, config)
    scales = np.maximum(neighbour_distances(raw.means), np.float32(1e-6))
    raw = round_gaussians(raw.means, scales, raw.colors, OPACITY)
    rows = np.floor(raw.means[:, 1] / (np.ptp(raw.means[:, 1]) or 1.0) * RESOLUTIONS[-1])
    return raw.rows(np.lexsort((raw.means[:, 0], rows)))


def _motion(raw: RawGaussians, size: float, rng: np.random.Generator) -> HexplaneMotion:
    """Random features in space, ones in time, a box around the Gaussians."""
    finest = max(CELLS * len(raw) ** 0.5, RESOLUTIONS[0])
    resolutions = np.array([[count] * 3 for count in RESOLUTIONS if count <= finest], np.int32)
    layout = Layout.of(resolutions)
    planes = rng.uniform(0.1, 0.5, (BLOCKS, layout.n_plane_cells, LANES))
    return HexplaneMotion(
        box=np.stack([raw.means.min(axis=0), raw.means.max(axis=0)]),
        unit=np.array([size / MILLIMETRES], np.float32),
        resolutions=resolutions,
        plane_cells=planes.astype(np.float32),
        time_cells=np.ones((TIME_ROWS, BLOCKS, layout.n_line_cells, LANES), np.float32),
        heads=Heads.random(len(resolutions) * BLOCKS * LANES, rng),
    )
