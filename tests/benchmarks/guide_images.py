"""The images of the guide and of the first page, from the built-in phantom alone.

xvfb-run -a -s "-screen 0 1920x1080x24" python -m tests.benchmarks.guide_images RUN

RUN is a finished reconstruction of the built-in phantom. Writes to assets/guide and assets/welcome.
"""

from __future__ import annotations

import argparse
import random
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from imgui_bundle.immapp import testing

from app.enhancement.frame_enhancer import Pictures
from app.gui.actions import floating_windows, remembered
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.work.settings import Settings
from app.runs.run_folder import RunFolder
from app.scenes.drawer import draw_view
from app.scenes.view_request import ViewRequest
from assets import guide_path, phantom_path, welcome_path
from renderer.clip import ByteImage
from renderer.gaussians import DynamicGaussians
from renderer.train.events import Evaluated, Started
from tests.app.gui.conftest import FakeJob
from tests.benchmarks.gui_pictures import window_in
from tests.benchmarks.person import UNPACED, Context, K, Person, quieten
from tests.benchmarks.picture_scenes import OMITTED, STEPS, progress

SIZE = (1280, 720)
BETWEEN = (0, 22, 1280, 602)
"""Left, top, right and bottom of what is between the menu bar and the timeline."""
QUALITY = (cv2.IMWRITE_JPEG_QUALITY, 88)
SAMPLE = (480, 300)
"""Pixels of an image of the first page."""
MEASURED = (0.45, 0.55)
"""Ends of the measured distance, as shares of the 3D view's width."""
NEAR = 24
"""Grey levels between a label and its colour, as there is tissue behind it."""
SETTLED = 30
"""Frames after which tooltips and animations have gone."""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("run", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        window = window_in(Path(folder), Settings(acknowledged=True))
        remembered.begin(window.state)
        # No folder of this computer is to be seen.
        window.state.places = replace(window.state.places, pictures=Path("Pictures/VesselSplat"))
        params = window.runner_params()
        params.ini_disable = True
        params.app_window_params.window_geometry.size = SIZE

        def drive(ctx: Context) -> None:
            quieten(ctx)
            run = Path(shutil.copytree(given.run, window.state.places.runs / "phantom"))
            _take(Shots(Person(ctx, window, phantom_path(), random.Random(0), UNPACED, run=run)))

        testing.run(test_function=drive, runner_params=params, add_ons_params=window.add_ons())


class Shots:
    """Takes images of the window, whole or of a panel."""

    def __init__(self, person: Person) -> None:
        self.person = person

    def shot(self) -> ByteImage:
        self.person.ctx.mouse_move_to_pos((2.0, 2.0))
        self.person.ctx.yield_(SETTLED)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "shot.png"
            testing.capture(self.person.ctx, str(path))
            image = cv2.imread(str(path))
        assert image is not None
        return np.asarray(image, np.uint8)

    def guide(self, name: str, window: str = "") -> None:
        """A window of its own, or all but the bars and the timeline."""
        left, top, right, bottom = BETWEEN
        if window:
            found = self.person.ctx.window_info(window).window
            left, top = round(found.pos.x), round(found.pos.y)
            right, bottom = left + round(found.size.x), top + round(found.size.y)
        cv2.imwrite(str(guide_path() / name), self.shot()[top:bottom, left:right], QUALITY)

    def measured(self, name: str) -> None:
        """Of the 3D view, the distance in the middle, with its label."""
        box = self.person.ctx.item_info("//3D view/view").rect_full
        across, down, image = box.max.x - box.min.x, box.max.y - box.min.y, self.shot()
        height = round(0.72 * down)
        width = height * SAMPLE[0] // SAMPLE[1]
        left, top = round(box.min.x), round(box.min.y + (down - height) / 2)
        seen = image[top : top + height, left : left + round(across)]
        start = cut_around(MEASURED[0] * across, end_of_label(seen), width)
        _write(name, seen[:, start : start + width])


def end_of_label(view: ByteImage) -> int:
    """First column right of the label of a distance, which is right of the middle; of BGR."""
    colour = theme.TAG_CAUTION
    bgr = 255 * np.array([colour.z, colour.y, colour.x])
    near = (np.abs(view.astype(np.float64) - bgr).max(axis=2) < NEAR).sum(axis=0) > view.shape[0] // 20
    middle = view.shape[1] // 2
    return int(np.flatnonzero(near[middle:])[-1]) + middle + 1


def cut_around(first: float, end: float, width: int) -> int:
    """Where so many columns begin that have these in their middle."""
    assert end - first < width, f"expected at most {width} columns, got {end - first:.0f}"
    return max(round((first + end - width) / 2), 0)


def _write(name: str, bgr: ByteImage) -> None:
    shape = cv2.INTER_AREA if bgr.shape[1] > SAMPLE[0] else cv2.INTER_CUBIC
    cv2.imwrite(str(welcome_path() / name), cv2.resize(bgr, SAMPLE, interpolation=shape), QUALITY)


def _enhanced(name: str, pictures: Pictures) -> None:
    """Left of a line the original."""
    assert pictures.enhanced is not None
    image, half = pictures.original.copy(), pictures.original.shape[1] // 2
    image[:, half:] = pictures.enhanced[:, half:]
    rows = image.shape[1] * SAMPLE[1] // SAMPLE[0]
    top = (image.shape[0] - rows) // 2
    large = cv2.resize(image[top : top + rows], SAMPLE, interpolation=cv2.INTER_CUBIC)
    large[:, SAMPLE[0] // 2 - 1 : SAMPLE[0] // 2 + 1] = 235
    _write(name, np.asarray(large[..., ::-1], np.uint8))


def _reconstructed(name: str, state: AppState) -> None:
    """From the side, as the 3D view shows it."""
    model, free = state.scene.model, state.scene.viewer.free
    assert model is not None
    (view,) = draw_view(ViewRequest.fitted(model, 0.3, free, SAMPLE))
    _write(name, np.asarray(view.image[..., ::-1], np.uint8))


def _train(person: Person, model: DynamicGaussians) -> None:
    """As it looks after a third of the steps."""
    person.click("//Reconstruction/###start")
    job = person.state.runs.reconstruction.job
    assert isinstance(job, FakeJob)
    job.inbox = [Started(0, STEPS, len(model), OMITTED), *progress(STEPS // 3), Evaluated(500, 30.2)]
    job.model = model
    person.ctx.yield_(3)
    person.ctx.window_focus("//3D view")
    person.wait(lambda: person.state.scene.view is not None, "the preview")


def _take(shots: Shots) -> None:
    person, state = shots.person, shots.person.state
    person.ctx.yield_(SETTLED)
    shots.guide("1-open.jpg", "//Images")
    person.open(phantom_path())
    person.ctx.window_focus("//Images")
    person.wait(lambda: state.timeline.strip is not None and state.picture.measured is not None, "all")
    shots.guide("2-enhance.jpg")
    person.press(K.w)
    person.wait(person.settled, "the wipe")
    person.click("//Enhancement/details/Measures")
    shots.guide("3-compare.jpg")
    assert state.picture.pictures is not None
    _enhanced("enhance.jpg", state.picture.pictures)
    person.press(K.v)
    person.ctx.window_focus("//Reconstruction")
    person.wait(person.settled, "both panes")
    assert person.run is not None
    _train(person, RunFolder(person.run).model())
    shots.guide("4-reconstruct.jpg")
    state.runs.reconstruction.job = None
    state.runs.reconstruction.status = "cancelled"
    person.open(person.run)
    person.ctx.window_focus("//3D view")
    person.wait(lambda: state.scene.view is not None, "the view")
    person.ctx.window_focus("//Cameras")
    person.drag("//3D view/view", (0.5, 0.5), (0.68, 0.4))
    person.ctx.yield_(SETTLED)
    shots.guide("5-view.jpg")
    _reconstructed("reconstruct.jpg", state)
    person.press(K.m)
    for x in MEASURED:
        person.drag("//3D view/view", (x, 0.5), (x, 0.5))
        person.ctx.yield_(SETTLED)
    shots.measured("measure.jpg")
    person.press(K.m)
    floating_windows.toggle(state.exports)
    person.ctx.yield_(SETTLED)
    shots.guide("6-export.jpg", "//Export")


if __name__ == "__main__":
    main()
