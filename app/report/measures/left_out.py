"""What each scene does not need, and what leaving it out saves and costs, from pairs of runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.report.bench import Bench, Clock
from app.report.costs import held_megabytes
from app.report.runs import schedule
from app.report.section import Cell, Column, Section, Table
from enhance import EnhanceParams, Enhancer, EnhanceResult
from enhance.accuracy import omissions
from renderer.clip import Clip, ClipError
from renderer.layouts import layout_of
from renderer.measuring.ablation import Side, ablation
from renderer.phantom import PhantomParams, write_phantom
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip
from renderer.train.events import Omission
from renderer.train.frame_store import FrameStore
from renderer.train.needs import decide
from renderer.train.trainer import TrainingError, require_depth, split

SMALL: Final = PhantomParams(n_frames=18, width=240, height=192)
STEPS: Final = 300
TIMED: Final = 40
LAPS: Final = 21
MOST_FRAMES: Final = 64
"""Of a further scene: of a longer one every n-th."""
MOST_GAUSSIANS: Final = 15_000
KINDS: Final = tuple((camera, tissue) for camera in ("fixed", "moving") for tissue in ("moving", "static"))
RECONSTRUCTION: Final = (
    *(Column("scene"), Column("left out"), Column("why"), Column("numbers saved")),
    *(Column("ms per step", ".2f"), Column("kept, ms", ".2f"), Column("time saved", "z.0%")),
    *(Column("MB", ".2f"), Column("kept, MB", ".2f"), Column("memory saved", "z.0%")),
    *(Column("PSNR, dB", ".2f"), Column("kept, dB", ".2f"), Column("error added, dB", "+z.2f")),
)
ENHANCEMENT: Final = (
    *(Column("scene"), Column("setting"), Column("left out"), Column("why"), Column("ms", ".2f")),
    *(Column("kept, ms", ".2f"), Column("time saved", "z.0%"), Column("MB", ".2f")),
    *(Column("kept, MB", ".2f"), Column("memory saved", "z.0%"), Column("error, largest"), Column("bound")),
)


def measure(bench: Bench, clock: Clock) -> Section:
    """Of the phantom in four kinds, the clip that is measured, and the further scenes."""
    missing: list[str] = []
    reconstruction: list[tuple[Cell, ...]] = []
    enhancement: list[tuple[Cell, ...]] = []
    for scene in _scenes(bench, missing):
        if clock.is_out:
            missing.append(f"{scene.name}: no time left")
            continue
        bench.say(f"omissions of {scene.name}")
        enhancement += _of_enhancement(scene)
        try:
            require_depth(scene)
            reconstruction += _of_reconstruction(scene, clock, missing)
        except (ClipError, TrainingError) as error:
            missing.append(f"{scene.name}, reconstruction: {str(error).split(':')[0]}")
    return Section(
        title="Omissions: what a scene does not need",
        sentences=(
            "Each row is a pair of runs with the same seed that differ in one part. A negative added error "
            "means that the run that keeps the part is worse.",
        ),
        tables=(
            Table(
                title="Reconstruction",
                columns=RECONSTRUCTION,
                rows=tuple(reconstruction),
                note=f"{STEPS} steps each; the time of a step is the median of several, the models of "
                "a scene taking turns; PSNR is of training frames held out of the fit, of a single image "
                "itself. MB: the model's parameters with their two moments. Estimated depth is from "
                "brightness, without a scale.",
            ),
            Table(
                title="Enhancement",
                columns=ENHANCEMENT,
                rows=tuple(enhancement),
                note="What these settings leave out for the first frame; where that is nothing, the "
                "time of the check is lost. MB: arrays held after a first image; no fewer, since a slider "
                "may need an omitted part at any moment. Error and bound in grey levels, unrounded.",
            ),
        ),
        not_measured=tuple(missing),
    )


def _scenes(bench: Bench, missing: list[str]) -> Iterator[Clip]:
    """Each under the name that tables give it."""
    for camera, tissue in KINDS:
        path = bench.work / f"phantom-{camera}-{tissue}"
        write_phantom(path, replace(SMALL, camera=camera, tissue=tissue))  # type: ignore[arg-type]
        yield replace(open_clip(path), name=f"phantom, {camera} camera, {tissue} tissue")
    if bench.given is not None:
        yield bench.clip
    for given, name in bench.scene_names.items():
        if scene := _opened(given, name, missing):
            yield scene


def _opened(path: Path, name: str, missing: list[str]) -> Clip | None:
    """Its depth guessed where it has none, so that reconstruction can be measured on it too; each frame is
    worked out once for all runs."""
    try:
        clip = open_clip(path)
        thinned, guessed = -(-len(clip) // MOST_FRAMES), not clip.has_depth and clip.points is None
        # Of a clip of which the field keeps one frame in so many, one in so many of these.
        step = thinned * layout_of(path).usual_step(path) if thinned > 1 else 1
        options = ClipOptions(
            frame_step=step if step > 1 else None, depth="brightness" if guessed else "auto"
        )
        said = (f", one frame in {step}" if step > 1 else "") + (", depth estimated" if guessed else "")
        clip = open_clip(path, options)
        return replace(clip, name=name + said, read_frame=cache(clip.read_frame))
    except ClipError as error:
        missing.append(f"{name}: {str(error).split(':')[0]}")
        return None


def _of_reconstruction(scene: Clip, clock: Clock, missing: list[str]) -> Iterator[tuple[Cell, ...]]:
    """One run without all that the scene does not need, and one for each part that is kept in."""
    usual = schedule(scene)
    count = min(usual.n_gaussians, MOST_GAUSSIANS)
    config = replace(usual, iterations=STEPS, n_gaussians=count, hold_out=len(scene) >= 8)
    frames = FrameStore.of(scene.read_frame(index) for index in split(scene, config)[0])
    omitted = decide(scene, frames, config).omitted
    del frames
    missing += [f"{scene.name}, {omission.what}: no pair" for omission in omitted if omission.part is None]
    kept = {omission: replace(config, keep=(omission.part,)) for omission in omitted if omission.part}
    sides = ablation(scene, [config, *kept.values()], TIMED)
    without: Side | None = None
    for omission in kept:
        if clock.is_out:
            missing.append(f"{scene.name}, {omission.what}: no time left")
            continue
        without = without or next(sides)
        yield _row(scene, omission, without, next(sides))


def _row(scene: Clip, omission: Omission, out: Side, kept: Side) -> tuple[Cell, ...]:
    return (
        *(scene.name, omission.what, omission.why, omission.saves),
        *(out.milliseconds, kept.milliseconds, 1 - out.milliseconds / kept.milliseconds),
        *(out.megabytes, kept.megabytes, 1 - out.megabytes / kept.megabytes),
        *(out.psnr, kept.psnr, kept.psnr - out.psnr),
    )


def _of_enhancement(scene: Clip) -> Iterator[tuple[Cell, ...]]:
    image = scene.read_image(0)
    for pair, out, kept in omissions(image, LAPS):
        assert out.milliseconds is not None
        assert kept.milliseconds is not None
        lean, whole = (_enhancer_mb(image, params) for params in (pair.lean, pair.whole))
        yield (
            *(scene.name, pair.name, ", ".join(each.what for each in out.omitted) or "nothing"),
            ", ".join(dict.fromkeys(each.why for each in out.omitted)),
            *(out.milliseconds, kept.milliseconds, 1 - out.milliseconds / kept.milliseconds),
            *(lean, whole, 1 - lean / whole, out.most, out.bound),
        )


def _enhancer_mb(image: NDArray[np.uint8], params: EnhanceParams) -> float:
    """Of a first picture."""
    enhancer = Enhancer()

    def first() -> EnhanceResult:
        enhancer.show(image)
        return enhancer.enhance(params)

    return held_megabytes(first)
