"""Error against run time of reading a clip: layouts and encodings of the same phantom, against the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import cycle
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from app.files.timing import Timing
from app.files.video import write_video
from app.report.bench import Bench, Clock
from app.report.diagrams import Point
from app.report.section import Cell, Column, Plate, Section, Table
from renderer.clip import Clip
from renderer.measuring.interleaved_timing import Laps, laps
from renderer.metrics import depth_rmse
from renderer.phantom import Phantom, PhantomParams, write_phantom
from renderer.sources import open_clip

PARAMS: Final = PhantomParams(n_frames=4, width=640, height=512)
LAPS: Final = 60
QUALITIES: Final = (95, 75)
COLUMNS: Final = (
    *(Column("clip"), Column("layout"), Column("ms per frame", ".2f", "low"), Column("± ms", ".2f")),
    *(Column("ms, image only", ".2f"), Column("mean error, grey levels"), Column("depth RMSE, mm")),
    Column("MB on disk", ".2f"),
)


def measure(bench: Bench, clock: Clock) -> Section:
    """See the file; the clip that is measured is timed as well."""
    bench.say("reading clips")
    truth = Phantom(PARAMS)
    frames = [truth.view(index).frame for index in range(PARAMS.n_frames)]
    written = dict(_written(bench.work / "reading", [frame.image for frame in frames]))
    paths = written if bench.given is None else {**written, bench.clip.name: bench.given}
    clips = {name: open_clip(path) for name, path in paths.items()}
    rows: list[tuple[Cell, ...]] = []
    points = []
    for (name, clip), (whole, image) in zip(clips.items(), _times([*paths.values()]), strict=True):
        if name not in written:
            rows.append(_row(name, clip, whole, image, None, None))
            continue
        read = [clip.read_frame(index) for index in range(len(clip))]
        apart = [np.abs(a.image.astype(float) - b.image).mean() for a, b in zip(read, frames, strict=True)]
        depths = [
            depth_rmse(a.depth, b.depth, b.depth_mask)
            for a, b in zip(read, frames, strict=True)
            if a.depth is not None and b.depth is not None
        ]
        error, depth = float(np.mean(apart)), float(np.mean(depths)) if depths else None
        rows.append(_row(name, clip, whole, image, error, depth))
        points.append(Point(series=clip.format, setting=name, seconds=whole.median, error=error,
                            spread=whole.spread, is_default=name == "EndoNeRF, PNG"))  # fmt: skip
    return Section(
        title="Reading clips: error against run time",
        sentences=(
            f"The same {PARAMS.n_frames} frames of {PARAMS.width}x{PARAMS.height} in each layout; a frame is "
            "image, masks and depth where the layout has them. No error: every byte is as written.",
        ),
        plates=(Plate.of_errors("Reading", points),),
        tables=(Table(title="Layouts", columns=COLUMNS, rows=tuple(rows)),),
    )


def _written(folder: Path, images: list[np.ndarray]) -> Iterator[tuple[str, Path]]:
    for layout, name in (("endonerf", "EndoNeRF, PNG"), ("scared", "SCARED, PNG and TIFF")):
        write_phantom(folder / layout, PARAMS, layout)  # type: ignore[arg-type]
        yield name, folder / layout
    for quality in QUALITIES:
        path = folder / f"jpeg-{quality}"
        path.mkdir()
        for index, image in enumerate(images):
            settings = [cv2.IMWRITE_JPEG_QUALITY, quality]
            cv2.imwrite(str(path / f"{index:03d}.jpg"), image[..., ::-1], settings)
        yield f"JPEG of quality {quality}", path
    write_video(folder / "video.mp4", iter(images), Timing(25.0))
    yield "video, H.264 or MPEG-4", folder / "video.mp4"


def _times(paths: Sequence[Path]) -> list[tuple[Laps, Laps]]:
    """Of a frame of each, and of its image alone, all in turns; each from a clip of its own, which reads on
    from where it is."""
    works: list[Callable[[], object]] = []
    for path in paths:
        frames, images = open_clip(path), open_clip(path)
        for clip, read in ((frames, frames.read_frame), (images, images.read_image)):
            indices = cycle(range(min(len(clip), PARAMS.n_frames)))
            works.append(lambda read=read, indices=indices: read(next(indices)))  # type: ignore[misc]
    taken = iter(laps(works, LAPS))
    return list(zip(taken, taken, strict=True))


def _row(
    name: str, clip: Clip, whole: Laps, image: Laps, error: float | None, depth: float | None
) -> tuple[Cell, ...]:
    paths = [clip.path] if clip.path.is_file() else [path for path in clip.path.rglob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in paths) / 1e6
    times = 1e3 * whole.median, 1e3 * whole.spread, 1e3 * image.median
    return (name, clip.format, *times, error, depth, size)
