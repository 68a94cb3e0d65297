"""Cost as work grows: time and memory against pixels, frames, Gaussians and clip length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from app.report.bench import Bench, Clock
from app.report.costs import held_megabytes
from app.report.diagrams import Curve, Growth
from app.report.section import Cell, Column, Section, Table
from enhance import Enhancer, enhance
from renderer.clip import Clip
from renderer.draw.context import OpenGLUnavailable, renderer_name, standalone_context
from renderer.draw.splat_view import SplatView
from renderer.measuring.ablation import step_times
from renderer.measuring.interleaved_timing import Laps, laps
from renderer.measuring.scattered import scattered
from renderer.phantom import Phantom, PhantomParams, write_phantom
from renderer.rasterize.cpu import Rasterizer
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Finished
from renderer.train.training import train

SIZES: Final = ((160, 128), (320, 256), (640, 512), (1280, 1024))
COUNTS: Final = (2_500, 10_000, 40_000, 160_000)
TRAINED: Final = (1_000, 4_000, 16_000)
LENGTHS: Final = (8, 16, 32, 64)
STEPS: Final = 24
REPEATS: Final = 15
PICTURES: Final = 61
"""Repeats of the enhancement, which is quick."""
COLUMNS: Final = (
    *(Column("what"), Column("grows with"), Column("exponent of time", "z.2f")),
    *(Column("exponent of memory", "z.2f"), Column("work, least"), Column("most")),
    *(Column("ms, least", ".3g"), Column("most", ".3g"), Column("MB, least", ".3g"), Column("most", ".3g")),
)


@dataclass(frozen=True)
class Series:
    """Cost of one thing at growing amounts of work."""

    name: str
    unit: str
    work: Sequence[float]
    times: Sequence[Laps]
    megabytes: Sequence[float]

    @property
    def ms(self) -> list[float]:
        """Medians."""
        return [1e3 * one.median for one in self.times]


def measure(bench: Bench, clock: Clock) -> Section:
    """See the file."""
    works: tuple[tuple[str, Callable[[Bench], list[Series]]], ...] = (
        ("enhancement", _enhancement), ("drawing", _drawing), ("training", _training),
    )  # fmt: skip
    series, missing = [], []
    for name, measured in works:
        if clock.is_out:
            missing.append(f"{name}: no time left")
            continue
        bench.say(f"cost of {name} as work grows")
        series += measured(bench)
    return Section(
        title="Cost as work grows",
        sentences=(
            "Lines are power laws fitted by least squares to the logarithms: an exponent of 1 is in "
            "proportion. Memory is that of the working arrays and models.",
        ),
        growths=tuple(_growths(series)),
        tables=(Table(title="Exponents", columns=COLUMNS, rows=tuple(_row(one) for one in series)),),
        not_measured=tuple(missing),
    )


def _growths(series: Sequence[Series]) -> list[Growth]:
    made = []
    for cost, name in (("ms", "ms"), ("megabytes", "MB")):
        for unit in dict.fromkeys(one.unit for one in series):
            own = [one for one in series if one.unit == unit]
            curves = tuple(Curve.through(one.name, one.work, getattr(one, cost)) for one in own)
            made.append(Growth(title=f"{name} against {unit}", work=unit, cost=name, curves=curves))
    return made


def _row(one: Series) -> tuple[Cell, ...]:
    time, memory = (Curve.through("", one.work, cost).exponent for cost in (one.ms, one.megabytes))
    return (
        *(one.name, one.unit, time, memory, one.work[0], one.work[-1]),
        *(one.ms[0], one.ms[-1], one.megabytes[0], one.megabytes[-1]),
    )


def _enhancement(bench: Bench) -> list[Series]:
    """The next frame of a stream, every pixel drawn once at full size and brought to each size."""
    whole = Phantom(PhantomParams(width=640, height=512)).view(0).frame.image
    enhance(whole)
    works, megabytes = [], []
    for size in SIZES:
        image = np.ascontiguousarray(cv2.resize(whole, size, interpolation=cv2.INTER_CUBIC), np.uint8)
        enhancer = Enhancer()

        def next_frame(enhancer: Enhancer = enhancer, image: np.ndarray = image) -> None:
            enhancer.show(image)
            enhancer.enhance()

        megabytes.append(held_megabytes(next_frame))
        works.append(next_frame)
    times = laps(works, PICTURES)
    return [Series("enhancement", "pixels", [w * h for w, h in SIZES], times, megabytes)]


def _drawing(bench: Bench) -> list[Series]:
    scenes = {"Gaussians": [(640, 512, count) for count in COUNTS], "pixels": [(*wh, 10_000) for wh in SIZES]}
    work = {"Gaussians": COUNTS, "pixels": [w * h for w, h in SIZES]}
    made = [_on_the_cpu(unit, scenes[unit], work[unit]) for unit in scenes]
    try:
        made += [_by_opengl(unit, scenes[unit], work[unit]) for unit in scenes]
    except OpenGLUnavailable as error:
        bench.say(f"OpenGL: {error}")
    return made


def _on_the_cpu(unit: str, scenes: Sequence[tuple[int, int, int]], work: Sequence[float]) -> Series:
    works, megabytes = [], []
    for width, height, count in scenes:
        splats, camera = scattered(width, height, count)
        drawn: list[Rasterizer] = []

        def draw(splats=splats, camera=camera, drawn=drawn) -> None:  # type: ignore[no-untyped-def]
            if not drawn:
                drawn.append(Rasterizer(camera.width, camera.height))
            drawn[0].forward(splats, camera)

        megabytes.append(held_megabytes(draw))
        works.append(draw)
    return Series("CPU rasteriser", unit, work, laps(works, REPEATS), megabytes)


def _by_opengl(unit: str, scenes: Sequence[tuple[int, int, int]], work: Sequence[float]) -> Series:
    """With every picture sorted, as where the camera turns; memory of records and target."""
    context = standalone_context()
    works, megabytes, name = [], [], renderer_name(context).split(" (")[0]
    for width, height, count in scenes:
        splats, camera = scattered(width, height, count)
        view, framebuffer = SplatView(context), context.simple_framebuffer((width, height), 4)
        view.upload(splats)

        def draw(view=view, camera=camera, framebuffer=framebuffer) -> None:  # type: ignore[no-untyped-def]
            view.forget_order()
            view.draw(camera, framebuffer)
            context.finish()

        works.append(draw)
        megabytes.append((count * 68 + width * height * 20) / 1e6)
    series = Series(f"OpenGL, {name}", unit, work, laps(works, REPEATS), megabytes)
    context.release()
    return series


def _training(bench: Bench) -> list[Series]:
    """A step of the own method at full size, on the phantom."""
    clips = {count: _clip(bench, PhantomParams(n_frames=count, width=160, height=128)) for count in LENGTHS}
    config = TrainConfig(n_gaussians=4_000)
    configs = [replace(config, n_gaussians=count) for count in TRAINED]
    sizes = SIZES[:3]
    larger = [_clip(bench, PhantomParams(n_frames=8, width=w, height=h)) for w, h in sizes]
    return [
        _steps("Gaussians", TRAINED, [(clips[16], one) for one in configs]),
        _steps("frames of the clip", LENGTHS, [(clip, config) for clip in clips.values()]),
        _steps("pixels", [w * h for w, h in sizes], [(clip, config) for clip in larger]),
    ]


def _clip(bench: Bench, params: PhantomParams) -> Clip:
    path = bench.work / f"growth-{params.n_frames}-{params.width}"
    if not path.exists():
        write_phantom(path, params)
    return open_clip(path)


def _steps(unit: str, work: Sequence[float], runs: Sequence[tuple[Clip, TrainConfig]]) -> Series:
    times = step_times([(clip, [config]) for clip, config in runs], STEPS)
    return Series("a training step", unit, work, times, [_model_mb(*run) for run in runs])


def _model_mb(clip: Clip, config: TrainConfig) -> float:
    """The model's numbers with their two moments, after one step."""
    finished = next(one for one in train(clip, replace(config, iterations=1)) if isinstance(one, Finished))
    return 3 * finished.model.n_bytes / 1e6
