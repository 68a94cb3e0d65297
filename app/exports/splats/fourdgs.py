"""A model through the clip as 4DGS, by the package fourdgs: samples at every frame, of which each holds how
its Gaussians go on to the next.

In scene units, y up and z towards the viewer, rounded to known bounds; colours by direction have no place.
Whatever sits beside the Gaussians, provenance too, lies beside the file.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.records import MovingSplats
from app.files.atomic import together, write_bytes
from app.files.provenance import write_sidecar
from app.runs.memory import free_memory
from app.scenes.scene import Scene
from renderer.model_windows import there_at, windows_of
from renderer.regular_files import read_whole
from renderer.rotations import unit_quats
from renderer.splat_files.y_up import y_up
from renderer.splats import Float32Array, Splats

SUFFIX: Final = ".4dgs"
NO_FOURDGS: Final = "a .4dgs file needs fourdgs: pip install fourdgs"
PROFILE: Final = "fine"
"""Positions within 2 % of the median size, sizes within 0.5 %, colours within half a grey level."""
DECIMALS: Final = 3
"""Of seconds, to which that rounds the moment at which a Gaussian is in its place."""
LASTING: Final = 1e6
"""Seconds after which a Gaussian would have begun to fade."""
BYTES: Final = 400
"""Of working memory that a Gaussian of one frame takes: the package writes a file in one go."""


def require_fourdgs() -> None:
    """Raises UserError: the package is not there."""
    if not has_fourdgs():
        raise UserError(NO_FOURDGS)


@cache
def has_fourdgs() -> bool:
    """Looked for once, and not loaded."""
    return find_spec("fourdgs") is not None


def write_fourdgs(record: MovingSplats, scene: Scene, target: Path) -> Generator[int, None, None]:
    """Yields frames done.

    Raises:
        UserError: no package, Gaussians that are others at every moment or none, or too little memory.
    """
    require_fourdgs()
    from fourdgs.keyframe_delta_file import write_sequence

    scene.require_same_tissue()
    frames = len(scene.cameras)
    _check(scene)
    samples, following = [], _there(scene, 0)
    for frame in range(frames):
        now, following = following, _there(scene, min(frame + 1, frames - 1))
        samples.append(_sample(now, following, frame, frames / record.seconds, record.seconds))
        yield frame + 1
    content = write_sequence(samples, record.seconds, profile=PROFILE, library="VesselSplat")
    with together(target) as place:
        write_bytes(place, content)
        write_sidecar(place, record.signed)


def read_fourdgs(path: Path) -> Iterator[NDArray[Any]]:
    """The values of each chunk, as they are stored. Raises UserError: it cannot be read here."""
    require_fourdgs()
    from fourdgs import FourdgsError
    from fourdgs.keyframe_delta_file import decode_streamed

    try:
        chunks = decode_streamed(read_whole(path)).chunks
    except FourdgsError as error:
        raise UserError(f"expected a .4dgs file of moving splats ({error}): {path}") from error
    for chunk in chunks:
        yield np.array([chunk.t0, chunk.t1])
        yield from (chunk.state.bins[attribute] for attribute in sorted(chunk.state.bins))


def _check(scene: Scene) -> None:
    """Raises UserError."""
    gaussians, frames = len(scene.model), len(scene.cameras)
    if not gaussians:
        raise UserError("expected a Gaussian at least, got none")
    needed = BYTES * sum(len(one) * len(one.frames(frames)) for one in windows_of(scene.model))
    free = free_memory()
    if needed > free:
        said = (
            f"{gaussians} Gaussians at {frames} frames need {needed / 1e9:.1f} GB, {free / 1e9:.1f} are free"
        )
        raise UserError(f"a .4dgs file is made in memory: {said}; a .usdc file is not")


class _There(NamedTuple):
    """What is drawn of a frame."""

    rows: NDArray[np.int64]
    """(N,) which Gaussians of the model, ascending: those of other windows are not there."""
    splats: Splats

    def means_after(self, following: _There) -> Float32Array:
        """(N, 3) where they are in the next frame; what is not there any more stays."""
        if not len(following.rows):
            return self.splats.means
        places = np.searchsorted(following.rows, self.rows).clip(max=len(following.rows) - 1)
        there = following.rows[places] == self.rows
        return np.where(there[:, None], following.splats.means[places], self.splats.means)


def _there(scene: Scene, frame: int) -> _There:
    time = scene.time(frame)
    raw = scene.model.motion.moved(scene.model.raw, time)
    return _There(np.flatnonzero(there_at(scene.model, time)), y_up(raw).splats())


def _sample(there: _There, following: _There, frame: int, rate: float, seconds: float) -> Any:
    """Straight on to the next."""
    from fourdgs import GaussianSet
    from fourdgs.keyframe_delta_writer import Sample

    now, count = there.splats, len(there.rows)
    motions = (there.means_after(following) - now.means) * np.float32(rate)
    time = frame / rate
    moment = round(time, DECIMALS)
    gaussians = GaussianSet(
        positions=now.means + motions * np.float32(moment - time),
        scales=now.scales,
        rotations=unit_quats(now.quats)[:, [1, 2, 3, 0]],
        colors=np.concatenate([now.colors.clip(0, 1), now.opacities[:, None]], axis=1),
        motions=motions,
        mu_t=np.full(count, moment),
        sigma_t=np.full(count, LASTING),
        win_lo=np.zeros(count),
        win_hi=np.full(count, seconds),
    )
    return Sample(time, there.rows, gaussians)
