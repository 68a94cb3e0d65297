"""A model looks the same in window, exports, commands and replays, in every render mode."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import moderngl
import numpy as np
import pytest

from app.files.image_files import read_image
from app.gui.actions import actions, comparing, job_actions, second_actions
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import GraphicsViewport
from app.gui.update.jobs import start_due
from app.gui.work.saving_edits import SaveRequest, write_splats
from app.gui.work.settings import Places
from app.runs.run_edits import save_edits
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu, over
from app.scenes.drawer import draw_view
from renderer.clip import ByteImage
from renderer.draw.offscreen import read_image as read_target
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.near_plane import near_plane
from renderer.splat_files import read_splats
from renderer.splat_files.inria_ply import ply_bytes
from renderer.splats import RenderMode
from renderer.unobserved import GREY
from tests.app.conftest import CONFIG, Cli, request_of
from tests.app.gui.conftest import FakeJob
from tests.app.gui.exporting import Exporter, same
from tests.app.gui.settling import show_finished, show_live

Kind = Literal["finished run", "edited run", "splat file"]
MODES: tuple[RenderMode, ...] = get_args(RenderMode)
SIZE = (64, 48)
"""Of the clip's frames."""
FRAME = 3
FEW_LEVELS = 3
"""Grey levels by which the card's half floats may be off; the modes are further apart."""


@pytest.fixture(scope="module", params=MODES)
def trained(
    request: pytest.FixtureRequest, clip_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A run of Gaussians so narrow that the mode is seen."""
    mode: RenderMode = request.param
    path, config = tmp_path_factory.mktemp("modes") / mode, replace(CONFIG, initial_spacing=0.3)
    list(run_training(request_of(clip_path, path, config=replace(config, render_mode=mode))))
    return path


@dataclass(frozen=True)
class Source:
    """What is opened, and the flags that make the command line draw what the window shows first."""

    path: Path
    flags: tuple[object, ...]
    frame: int


@pytest.fixture(params=get_args(Kind))
def source(request: pytest.FixtureRequest, trained: Path, tmp_path: Path) -> Source:
    kind: Kind = request.param
    run = RunFolder(trained)
    if kind == "finished run":
        return Source(trained, ("--frames", FRAME), FRAME)
    model, mode = run.model(), run.record().config.render_mode
    if kind == "splat file":
        path = tmp_path / "some.ply"
        path.write_bytes(ply_bytes(model.raw, mode))
        return Source(path, ("--size", *SIZE), 0)
    folder, none = RunFolder(Path(shutil.copytree(trained, tmp_path / "run"))), Edits.none(len(model))
    gone = np.arange(len(model)) % 3 == 0
    save_edits(folder, none.selecting(Mask.of(gone), "replace").deleting())
    return Source(folder.path, ("--frames", FRAME), FRAME)


@pytest.fixture
def window(places: Places, source: Source) -> Exporter:
    """At the moment that the flags name."""
    opened = Exporter(places, source.path)
    opened.state.scene.size = opened.state.exports.view_size = SIZE
    actions.seek(opened.state, source.frame)
    return opened


@pytest.fixture
def places(tmp_path: Path) -> Places:
    return Places(tmp_path / "config", tmp_path / "runs", tmp_path / "pictures")


def shown(window: Exporter) -> ByteImage:
    """As background work draws it."""
    request = window.state.view_request
    assert request is not None
    (view,) = draw_view(request)
    return view.image


def rendered(vesselsplat: Cli, source: Source, out: Path, *flags: object) -> Path:
    call = vesselsplat("render", source.path, "--out", out, *source.flags, *flags)
    assert call.code == 0, call.error
    return out / f"frame-{source.frame:06d}.png"


def inside(page: Path) -> ByteImage:
    """The one picture on a page, without caption and notice."""
    image = read_image(page)
    top = (image.shape[0] - SIZE[1]) // 2
    return np.asarray(image[top : top + SIZE[1], : SIZE[0]], np.uint8)


def drawn_of(run: RunFolder, mode: RenderMode) -> ByteImage:
    """The oracle: by the rasteriser itself."""
    record, model = run.record(), run.model()
    camera = record.cameras[FRAME]
    return over(
        draw_on_cpu(model.at(record.time(FRAME)), camera, DrawOptions(near_plane(model, camera), mode)), GREY
    )


def test_the_modes_are_seen(trained: Path) -> None:
    """Without that this file could not fail."""
    one, other = (drawn_of(RunFolder(trained), mode).astype(int) for mode in MODES)
    away = np.abs(one - other)
    assert away.max() > 10 * FEW_LEVELS
    assert (away.max(axis=2) > FEW_LEVELS).mean() > 0.05


def test_the_window_draws_what_the_command_draws(
    window: Exporter, source: Source, tmp_path: Path, vesselsplat: Cli
) -> None:
    picture = shown(window)
    assert picture.max() > 60
    np.testing.assert_array_equal(picture, read_image(rendered(vesselsplat, source, tmp_path / "out")))


@pytest.mark.gl
@pytest.mark.parametrize("baked", [False, True])
def test_the_card_draws_what_the_command_draws(
    ctx: moderngl.Context, window: Exporter, source: Source, tmp_path: Path, vesselsplat: Cli, baked: bool
) -> None:
    """From the model of the moment, and from keyframes of what moves."""
    wanted = read_image(rendered(vesselsplat, source, tmp_path / "out", "--with", "gl")).astype(int)
    window.state.scene.processor_draws = not baked
    window.turn(40)
    shown = window.state.scene
    assert (shown.keyframes_of(shown.model) is not None) == (baked and source.path.is_dir())
    viewport = GraphicsViewport(ctx, Textures(ctx))
    assert viewport.show(window.state) is not None
    assert viewport._target is not None
    away = np.abs(np.rint(read_target(viewport._target) * 255).astype(int) - wanted)
    assert away.max() <= FEW_LEVELS
    viewport.release()


def test_an_exported_view_is_that_of_the_command_and_comes_again(
    window: Exporter, source: Source, tmp_path: Path, vesselsplat: Cli
) -> None:
    exported, picture = window.made("3D view"), rendered(vesselsplat, source, tmp_path / "out")
    np.testing.assert_array_equal(inside(exported), read_image(picture))
    assert same(exported, source.path)
    assert same(picture, source.path)


def test_an_exported_video_comes_again(window: Exporter, source: Source) -> None:
    assert same(window.made("video through time"), source.path)


def test_a_command_s_video_comes_again(trained: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    video = tmp_path / "own.mp4"
    assert vesselsplat("export", trained, "--video", video, "--frames", FRAME).code == 0
    assert same(video, trained)


def test_a_second_view_is_drawn_as_the_first_would_be(
    window: Exporter, source: Source, tmp_path: Path, vesselsplat: Cli
) -> None:
    second_actions.open_second(window.state, source.path)
    window.turn()
    request = window.state.second_request
    assert request is not None
    (view,) = draw_view(request)
    # Edits of a run stay with the window that makes them: beside it is the run as it was trained.
    flags = () if source.path.is_file() else ("--as-trained",)
    picture = rendered(vesselsplat, source, tmp_path / "out", *flags)
    np.testing.assert_array_equal(view.image, read_image(picture))
    assert same(window.made("3D view"), source.path)


def test_a_pane_shows_the_run_as_the_command_does_and_comes_again(
    trained: Path, clip_path: Path, places: Places, tmp_path: Path, vesselsplat: Cli
) -> None:
    window = Exporter(places, trained)
    comparing.choose_source(window.state, "left", "render")
    actions.seek(window.state, FRAME)
    window.turn(6)
    exported = window.made("left pane")
    source = Source(trained, ("--frames", FRAME), FRAME)
    np.testing.assert_array_equal(
        inside(exported), read_image(rendered(vesselsplat, source, tmp_path / "out"))
    )
    assert same(exported, clip_path, trained)


@pytest.fixture
def training(trained: Path, clip_path: Path, places: Places) -> Exporter:
    """The window that makes the run."""
    window = Exporter(places, clip_path)
    config = RunFolder(trained).record().config
    window.state.runs.reconstruction.config = config
    job_actions.start_reconstruction(window.state)
    start_due(window.state, FakeJob)
    request = request_of(clip_path, trained, config=config)
    window.state.runs.reconstruction.request = request
    window.state.scene.size = SIZE
    actions.seek(window.state, FRAME)
    return window


def test_a_run_is_previewed_as_it_will_be_drawn(training: Exporter, trained: Path) -> None:
    show_live(training.state, RunFolder(trained).model())
    mode = RunFolder(trained).record().config.render_mode
    np.testing.assert_array_equal(shown(training), drawn_of(RunFolder(trained), mode))


def test_a_run_that_has_just_been_made_is_drawn_as_it_was_trained(training: Exporter, trained: Path) -> None:
    show_live(training.state, RunFolder(trained).model())
    show_finished(training.state, RunFolder(trained).model())
    training.state.runs.reconstruction.status = "finished"
    mode = RunFolder(trained).record().config.render_mode
    np.testing.assert_array_equal(shown(training), drawn_of(RunFolder(trained), mode))
    assert same(training.made("3D view"), trained)


def test_a_run_that_was_cut_short_is_drawn_as_it_is_trained(
    trained: Path, tmp_path: Path, places: Places
) -> None:
    folder = RunFolder(Path(shutil.copytree(trained, tmp_path / "short")))
    folder.model_path.unlink()
    window = Exporter(places, folder.path)
    window.state.scene.size = SIZE
    request = window.state.view_request
    assert window.state.scene.model is not None
    assert window.state.scene.model.live
    assert request is not None
    splats = window.state.scene.model.model.at(request.time)
    mode = folder.record().config.render_mode
    wanted = over(draw_on_cpu(splats, request.camera, DrawOptions(request.near, mode)), GREY)
    np.testing.assert_array_equal(shown(window), wanted)


def test_splats_are_saved_with_the_mode_and_come_again(
    window: Exporter, source: Source, trained: Path
) -> None:
    state, path = window.state, source.path.with_suffix(".ply")
    editing = state.editing
    assert editing.base is not None
    saved = write_splats(SaveRequest(editing.base, path, editing.edits, editing.saved, state.time))
    assert read_splats(saved).mode == RunFolder(trained).record().config.render_mode
    assert same(saved, source.path)
