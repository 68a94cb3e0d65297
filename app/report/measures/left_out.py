"""What each scene does not need, and what leaving it out saves and costs, from pairs of runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

from app.report.bench import Bench, Clock
from app.report.measures.training import schedule
from app.report.section import Cell, Column, Section, Table
from enhance.accuracy import omissions
from renderer.clip import Clip, ClipError
from renderer.left_out import Side, compared
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.events import Omission
from renderer.train.needs import decide
from renderer.train.trainer import require_depth, split

SMALL: Final = PhantomParams(n_frames=18, width=240, height=192)
STEPS: Final = 300
TIMED: Final = 40
MOST_GAUSSIANS: Final = 30_000
KINDS: Final = tuple((camera, tissue) for camera in ("fixed", "moving") for tissue in ("moving", "static"))
RECONSTRUCTION: Final = (
    *(Column(name="scene"), Column(name="left out"), Column(name="why"), Column(name="numbers saved")),
    *(Column(name="ms a step", form=".2f"), Column(name="kept in, ms", form=".2f")),
    *(Column(name="time saved", form=".0%"), Column(name="MB", form=".2f")),
    *(Column(name="kept in, MB", form=".2f"), Column(name="memory saved", form=".0%")),
    *(Column(name="PSNR, dB", form=".2f"), Column(name="kept in, dB", form=".2f")),
    Column(name="error added, dB", form="+.2f"),
)
ENHANCEMENT: Final = (
    *(Column(name="scene"), Column(name="setting")),
    *(Column(name="ms", form=".2f"), Column(name="kept in, ms", form=".2f")),
    *(Column(name="time saved", form=".0%"), Column(name="error, largest"), Column(name="bound")),
)


@dataclass(frozen=True, eq=False)
class Scene:
    """A clip under the name that tables give it."""

    name: str
    clip: Clip


def measure(bench: Bench, clock: Clock) -> Section:
    """Of the phantom in four kinds, the clip that is measured, and the further scenes."""
    missing: list[str] = []
    reconstruction: list[tuple[Cell, ...]] = []
    enhancement: list[tuple[Cell, ...]] = []
    for scene in _scenes(bench, missing):
        if clock.is_out:
            missing.append(f"{scene.name}: the time was used up")
            continue
        bench.say(f"what {scene.name} does without")
        enhancement += _of_enhancement(scene)
        try:
            require_depth(scene.clip)
            reconstruction += _of_reconstruction(scene, clock, missing)
        except ClipError as error:
            missing.append(f"{scene.name}, reconstruction: {str(error).split(':')[0]}")
    return Section(
        title="Left out: what a scene does not need",
        sentences=(
            "Each row is a pair of runs of one seed that differ in one thing. A negative error added says "
            "that the run that keeps it in is worse on frames that neither run has seen.",
        ),
        tables=(
            Table(
                title="Reconstruction",
                columns=RECONSTRUCTION,
                rows=tuple(reconstruction),
                note=f"{STEPS} steps each; the time of a step is the median of some that both models take in "
                "turns; PSNR is of training frames held out of the fit. MB: the model's numbers with their "
                "two moments.",
            ),
            Table(
                title="Enhancement",
                columns=ENHANCEMENT,
                rows=tuple(enhancement),
                note="What these settings let be left out of the first photo. Error and bound in grey "
                "levels, unrounded.",
            ),
        ),
        not_measured=tuple(missing),
    )


def _scenes(bench: Bench, missing: list[str]) -> Iterator[Scene]:
    for camera, tissue in KINDS:
        path = bench.work / f"phantom-{camera}-{tissue}"
        write_phantom(path, _kind(camera, tissue))  # type: ignore[arg-type]
        yield Scene(f"phantom, {camera} camera, {tissue} tissue", open_clip(path))
    if bench.given is not None:
        yield Scene(bench.clip.name, bench.clip)
    for given in bench.scenes:
        if scene := _opened(given, missing):
            yield scene


def _kind(camera: Literal["fixed", "moving"], tissue: Literal["moving", "static"]) -> PhantomParams:
    return replace(SMALL, camera=camera, tissue=tissue)


def _opened(path: Path, missing: list[str]) -> Scene | None:
    try:
        return Scene(path.stem, open_clip(path))
    except ClipError as error:
        missing.append(f"{path.name}: {str(error).split(':')[0]}")
        return None


def _of_reconstruction(scene: Scene, clock: Clock, missing: list[str]) -> Iterator[tuple[Cell, ...]]:
    usual = schedule(scene.clip)
    count = min(usual.n_gaussians, MOST_GAUSSIANS)
    config = replace(usual, iterations=STEPS, n_gaussians=count, hold_out=len(scene.clip) >= 8)
    frames = [scene.clip.read_frame(index) for index in split(scene.clip, config)[0]]
    for omission in decide(scene.clip, frames, config).omitted:
        if omission.part is None or clock.is_out:
            why = "the time was used up" if omission.part else "no pair"
            missing.append(f"{scene.name}, {omission.what}: {why}")
            continue
        sides = compared(scene.clip, config, replace(config, keep=(omission.part,)), TIMED)
        yield _row(scene, omission, sides)


def _row(scene: Scene, omission: Omission, sides: tuple[Side, Side]) -> tuple[Cell, ...]:
    out, kept = sides
    return (
        *(scene.name, omission.what, omission.why, omission.saves),
        *(out.milliseconds, kept.milliseconds, 1 - out.milliseconds / kept.milliseconds),
        *(out.megabytes, kept.megabytes, 1 - out.megabytes / kept.megabytes),
        *(out.psnr, kept.psnr, kept.psnr - out.psnr),
    )


def _of_enhancement(scene: Scene) -> Iterator[tuple[Cell, ...]]:
    rows = list(omissions(scene.clip.read_image(0)))
    for out, kept in zip(rows[::2], rows[1::2], strict=True):
        assert out.milliseconds is not None
        assert kept.milliseconds is not None
        saved = 1 - out.milliseconds / kept.milliseconds
        yield scene.name, out.setting, out.milliseconds, kept.milliseconds, saved, out.most, out.bound
