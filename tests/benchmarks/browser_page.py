"""`python -m tests.benchmarks.browser_page RUN [--browser chromium]`: the page for browsers, drawn by one.

A headless Chromium draws moments of the page at the clip's size; printed are PSNR and the largest difference
to the CPU renderer over the same ground, bytes of the file, and bytes a Gaussian and frame.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

from app.exports.browser.of_scene import browser_model
from app.exports.make import make
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu, over
from app.scenes.scene import open_scene
from renderer.unobserved import GREY

FLAGS = ("--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
BAR = 87
"""Pixels that a headless window keeps for itself."""


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("run", type=Path)
    parser.add_argument("--browser", default="chromium")
    given = parser.parse_args()
    scene = open_scene(given.run)
    camera, frames = scene.cameras[0], len(scene.cameras)
    with tempfile.TemporaryDirectory() as work:
        page, shot = Path(work, "model.html"), Path(work, "shot.png")
        run_to_end(make(browser_model(scene, camera, 25.0), Opened(model=scene), page))
        size = page.stat().st_size
        print(f"{size / 1e6:.2f} MB, {size / len(scene.model) / frames:.2f} bytes a Gaussian and frame")
        for time in (0.0, 0.25, 0.38, 0.5, 0.75, 1.0):
            window = f"--window-size={camera.width},{camera.height + BAR}"
            asked = ["--hide-scrollbars", "--virtual-time-budget=20000", f"--screenshot={shot}"]
            command = [given.browser, *FLAGS, window, *asked, f"{page.as_uri()}#still={time}"]
            subprocess.run(command, check=True, capture_output=True)
            seen = cv2.cvtColor(cv2.imread(str(shot)), cv2.COLOR_BGR2RGB)[: camera.height, : camera.width]
            seen_by = scene.camera_at(time)
            ours = over(draw_on_cpu(scene.model.at(time), seen_by, DrawOptions(scene.near, scene.mode)), GREY)
            apart = np.abs(seen.astype(float) - ours)
            quality = 10 * np.log10(255**2 / np.mean(apart**2))
            print(f"time {time:.2f}: {quality:.1f} dB, at most {apart.max():.0f} grey levels")


if __name__ == "__main__":
    main()
