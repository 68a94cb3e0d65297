"""The dark surround of a round image is neither trained nor measured, and said to be left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import pytest

from app.gui.work.omissions import OmissionsRequest
from app.report.runs import Runs
from app.runs.clip_selection import WHOLE
from app.runs.dark_surround import lit_field, omission_of
from app.runs.left_out import left_out_of, with_found
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.runs.trained_clip import run_clip
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from app.scenes.scene import open_scene
from enhance.field import FieldOfView, overlap
from renderer.clip import BoolImage, Frame
from renderer.metrics import psnr_masked
from renderer.near_plane import near_plane
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Omission, Started, Warned
from tests.app.conftest import Cli, request_of
from tests.app.looking import found_omissions

WIDTH, HEIGHT, RADIUS = 128, 96, 44
CONFIG = TrainConfig(iterations=400, n_gaussians=2500, checkpoint_every=200)
WITH_SURROUND = replace(CONFIG, n_gaussians=1508, keep=("surround",))
"""As many Gaussians on tissue: of 2500, 1131 are left without the surround."""


def disc(radius: float) -> BoolImage:
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    return np.asarray(np.hypot(x - WIDTH / 2, y - HEIGHT / 2) < radius)


@pytest.fixture(scope="module")
def round_clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The phantom through a round view; its depth reaches into the dark, and its masks are of tools alone."""
    path = tmp_path_factory.mktemp("round") / "clip"
    write_phantom(path, PhantomParams(n_frames=17, width=WIDTH, height=HEIGHT))
    for file in (path / "images").iterdir():
        image = cv2.imread(str(file))
        assert image is not None
        image[~disc(RADIUS)] = 3
        cv2.imwrite(str(file), image)
    return path


class Trained(NamedTuple):
    run: RunFolder
    messages: list[str]
    started: Started


@pytest.fixture(scope="module")
def trained(round_clip: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Trained]:
    @cache
    def of(config: TrainConfig = CONFIG) -> Trained:
        path = tmp_path_factory.mktemp("runs") / "run"
        events = list(run_training(request_of(round_clip, path, config=config)))
        messages = [event.message for event in events if isinstance(event, Warned)]
        (started,) = (event for event in events if isinstance(event, Started))
        return Trained(RunFolder(path), messages, started)

    return of


def quality(run: RunFolder) -> tuple[float, float, float]:
    """PSNR of tissue well inside the view, alpha well outside, and the share of Gaussians there."""
    clip, model = open_clip(Path(run.record().clip.path)), run.model()
    inside, alphas = [], []
    for index in clip.test_indices:
        frame = clip.read_frame(index)
        drawn = draw_on_cpu(model.at(frame.time), frame.camera, DrawOptions(near_plane(model, frame.camera)))
        mask = frame.tissue_mask & disc(RADIUS - 4)
        inside.append(psnr_masked(drawn.bytes / 255.0, frame.image / 255.0, mask))
        alphas.append(drawn.alpha[~disc(RADIUS + 4)].mean())
    places, _ = clip.cameras[0].project(model.at(0.0).means.astype(float))
    beyond = np.hypot(places[:, 0] - WIDTH / 2, places[:, 1] - HEIGHT / 2) > RADIUS + 2
    return float(np.mean(inside)), float(np.mean(alphas)), float(beyond.mean())


def test_no_gaussians_cover_it_and_tissue_is_no_worse(trained: Callable[..., Trained]) -> None:
    """By .85 dB better over four seeds, .82 at least."""
    without, kept = quality(trained().run), quality(trained(WITH_SURROUND).run)
    assert without[0] > kept[0]
    assert without[1] < 0.02
    assert without[2] < 0.005
    assert len(trained().run.model()) < 0.5 * CONFIG.n_gaussians
    # As many lie on tissue where the surround is kept.
    on_tissue = (1 - kept[2]) * len(trained(WITH_SURROUND).run.model())
    assert on_tissue == pytest.approx(len(trained().run.model()), rel=0.05)
    # The test's own clip could be one that has nothing there anyway.
    assert kept[1] > 0.5
    assert kept[2] > 0.1


def test_it_is_said_at_the_start_and_in_the_record(trained: Callable[..., Trained]) -> None:
    run, messages, started = trained()
    (line,) = (message for message in messages if "surround" in message)
    assert line == "left out: the dark surround, 55 % of the pixels and Gaussians"
    assert (started.omitted[0].what, started.omitted[0].part) == ("dark surround", "surround")
    assert run.omitted()[0] == started.omitted[0]
    field = run.record().clip.part.field_of_view
    assert field is not None
    assert np.count_nonzero(field.mask() != disc(RADIUS)) < 0.05 * WIDTH * HEIGHT
    source = open_scene(run.path).record.clip
    assert source is not None
    assert source.part is not None
    assert "without the dark surround" in source.part.told()
    frame = run_clip(run.record()).read_frame(1)
    assert not frame.tissue_mask[~field.mask()].any()
    assert not frame.evaluation_mask[~field.mask()].any()
    kept = trained(WITH_SURROUND)
    assert not any("surround" in message for message in kept.messages)
    assert kept.run.record().clip.part.field_of_view is None


def known_before(omitted: tuple[Omission, ...]) -> list[Omission]:
    """But for how many control values there are, which tracks say."""
    return [each for each in omitted if "control values" not in each.what]


def test_the_window_says_so_before_it_starts(trained: Callable[..., Trained], round_clip: Path) -> None:
    clip = open_clip(round_clip)
    told = found_omissions(OmissionsRequest(clip, CONFIG))
    assert known_before(told.omitted) == known_before(trained().started.omitted)
    assert [each.what for each in told.omitted] == [each.what for each in trained().started.omitted]
    kept = found_omissions(OmissionsRequest(clip, WITH_SURROUND))
    assert known_before(kept.omitted) == known_before(trained(WITH_SURROUND).started.omitted)
    assert [each.part for each in kept.kept] == ["surround"]


def test_it_goes_on_as_it_began(round_clip: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    flags = (round_clip, "--run", tmp_path / "run", "--iterations", 2)
    first, again = vesselsplat("train", *flags), vesselsplat("train", *flags, "--resume")
    assert (first.code, again.code) == (0, 0), again.error
    assert "left out: the dark surround, 55 % of the pixels and Gaussians" in first.error
    assert "dark surround" in first.out


def test_where_masks_leave_it_out_or_nothing_is_dark_there_is_none(round_clip: Path, clip_path: Path) -> None:
    frames = [open_clip(round_clip).read_frame(index) for index in range(3)]
    field = lit_field(frames)
    assert field is not None
    own = [replace(frame, tissue_mask=frame.tissue_mask & field.mask()) for frame in frames]
    assert lit_field(own) is None
    # A dark moment and a flash do not move it.
    odd = [replace(frames[0], image=np.full_like(frames[0].image, level)) for level in (0, 255)]
    other = lit_field([*frames, *odd])
    assert other is not None
    assert overlap(field, other) > 0.98
    whole = open_clip(clip_path)
    assert lit_field(whole.read_frame(index) for index in range(3)) is None
    assert lit_field([frames[0], whole.read_frame(0)]) is None


def test_thin_dark_bars_at_the_border_are_left_out_unless_they_are_kept(clip_path: Path) -> None:
    clip = open_clip(clip_path)

    def barred(index: int) -> Frame:
        frame = clip.read_frame(index)
        image = frame.image.copy()
        image[-2:, : clip.size[0] // 2] = 6  # Not all along, as where an image is turned a little.
        return replace(frame, image=image)

    indices, height = range(4), clip.size[1]
    assert with_found(WHOLE, clip.read_frame, indices, ()).field_of_view is None
    found = with_found(WHOLE, barred, indices, ())
    assert found.field_of_view is not None
    kept = found.field_of_view.mask()
    assert kept[: height - 3].all()
    assert not kept[height - 3 :].any()
    frame = found.cleared(barred(0))
    assert not frame.tissue_mask[height - 3 :].any()
    assert not frame.evaluation_mask[height - 3 :].any()
    _, (line,) = left_out_of(replace(found, tools=None))
    assert line.startswith("left out: the dark surround, ")
    assert with_found(WHOLE, barred, indices, ("surround",)).field_of_view is None


@pytest.mark.parametrize(("rows", "said"), [(2, "less than 1 %"), (6, "1 %"), (240, "50 %")])
def test_bars_of_a_row_or_two_are_not_said_to_be_nothing(rows: int, said: str) -> None:
    field = FieldOfView(width=640, height=480, polygon=((0, 0), (640, 0), (640, 480 - rows), (0, 480 - rows)))
    assert omission_of(field).saves == f"{said} of the pixels and Gaussians"


def test_a_report_measures_a_run_without_what_it_left_out(round_clip: Path, tmp_path: Path) -> None:
    runs = Runs(round_clip, open_clip(round_clip), tmp_path, lambda said: None)
    clip = runs.trained(replace(CONFIG, iterations=6)).clip
    tissue = clip.read_frame(clip.test_indices[0]).tissue_mask
    assert tissue.any()
    assert not tissue[~disc(RADIUS + 3)].any()
