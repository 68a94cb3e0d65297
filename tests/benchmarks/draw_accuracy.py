"""Error against milliseconds of drawing a trained run with OpenGL, and of baking it into keyframes.

python -m tests.benchmarks.draw_accuracy RUN [FRAME]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from app.runs.run_folder import RunFolder
from renderer.draw.context import renderer_name, standalone_context
from renderer.measuring.drawing_accuracy import keyframes, opengl
from renderer.measuring.drawing_row import Row
from renderer.measuring.raster_accuracy import exact
from renderer.near_plane import middle_distance, near_plane


def main(run_path: Path, frame: int) -> None:
    run = RunFolder(run_path)
    record, model = run.record(), run.model()
    camera, context = record.cameras[frame], standalone_context()
    near = near_plane(model, camera)
    splats = model.at(record.time(frame))
    truth = exact(splats, camera, near)
    size = f"{camera.width}x{camera.height}"
    print(f"{renderer_name(context)}; {len(model)} Gaussians at {size}, frame {frame}")
    errors = f"{'PSNR dB':>9}{'mean':>9}{'p99.9':>9}{'max':>9}"
    print(f"{'':14}{'setting':36}{errors}{'ms':>9}{'± ms':>8}{'MB':>8}{'bake s':>8}")
    for row in opengl(context, splats, camera, near, truth):
        report(row)
    times = [record.time(index) for index in range(record.clip.frames)]
    pixel = middle_distance(model, camera) / camera.fx
    for row in keyframes(context, model, camera, times, near, pixel):
        report(row)


def report(row: Row) -> None:
    """Errors in grey levels."""
    megabytes, baking = (math.nan if value is None else value for value in (row.megabytes, row.baking))
    print(
        f"{row.group:14}{row.setting:36}{row.psnr:9.1f}{row.mean:9.4f}{row.p999:9.3f}{row.most:9.3f}"
        f"{row.milliseconds:9.2f}{row.spread:8.2f}{megabytes:8.1f}{baking:8.2f}",
        flush=True,
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1)
