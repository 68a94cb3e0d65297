"""`vesselsplat render`: the pictures of a run, where each comes from, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import moderngl
import numpy as np
import pytest

import app.scenes.drawer as drawer_module
import app.scenes.scene as scene_module
from app.errors import UserError
from app.evaluation.evaluate import open_evaluation
from app.exports.replay.again import replay
from app.files.provenance import read_provenance
from app.gui.state.editing import tinted_model
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.scenes.backgrounds import BACKGROUNDS, BackgroundName
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu, over
from app.scenes.drawer import draw_view
from app.scenes.free_camera import FreeView
from app.scenes.renderers import Renderer, drawer
from app.scenes.scene import open_scene
from app.scenes.view_request import ViewRequest
from renderer.camera import BoolArray, Camera
from renderer.draw.offscreen import render_offscreen
from renderer.draw.splat_view import Precision
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.gaussians import DynamicGaussians
from renderer.measuring.raster_accuracy import exact
from renderer.metrics import psnr
from renderer.near_plane import near_plane
from renderer.rasterize.cpu import render
from renderer.splat_files import read_splats
from renderer.splat_files.inria_ply import ply_bytes
from renderer.unobserved import GREY
from tests.app.conftest import CONFIG, Cli, request_of
from tests.app.fake_steps import model_of
from tests.renderer.scenes import random_splats, turned_camera
from tests.renderer.splat_files.files import gaussians

ENDS = ("-depth.npy", "-depth.npy.json", "-depth.png", ".png")


def test_render_writes_pictures_that_know_where_they_come_from(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    out = tmp_path / "out"
    assert vesselsplat("render", runs["original"], "--out", out, "--frames", "test", "--depth").code == 0
    names = [f"frame-00000{index}{end}" for index in (1, 9) for end in ENDS]
    assert sorted(path.name for path in out.iterdir()) == names
    run = RunFolder(runs["original"])
    record, model = run.record(), run.model()
    drawn = draw_on_cpu(
        model.at(record.time(9)), record.cameras[9], DrawOptions(near_plane(model, record.cameras[9]))
    )
    assert np.array_equal(cv2.imread(str(out / "frame-000009.png"))[..., ::-1], over(drawn, GREY))
    assert np.array_equal(np.load(out / "frame-000009-depth.npy"), drawn.depth)
    facts = read_provenance(out / "frame-000009.png")
    assert (facts["frame"], facts["time"]) == (9, record.time(9))
    assert facts["camera"] == record.cameras[9].to_json()
    assert str(runs["original"].parent) not in json.dumps(facts)


def test_a_run_is_drawn_exported_and_measured_as_it_was_trained(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    path, config = tmp_path / "run", replace(CONFIG, render_mode="mip", initial_spacing=0.3)
    list(run_training(request_of(clip_path, path, config=config)))
    run = RunFolder(path)
    record, model = run.record(), run.model()
    at, near = (model.at(record.time(9)), record.cameras[9]), near_plane(model, record.cameras[9])
    picture = over(draw_on_cpu(*at, DrawOptions(near, "mip")), GREY)
    assert not np.array_equal(picture, over(draw_on_cpu(*at, DrawOptions(near)), GREY))
    assert vesselsplat("render", path, "--out", tmp_path / "out", "--frames", 9).code == 0
    assert np.array_equal(cv2.imread(str(tmp_path / "out" / "frame-000009.png"))[..., ::-1], picture)
    assert vesselsplat("export", path, "--ply", tmp_path / "ply", "--frames", 9).code == 0
    assert read_splats(tmp_path / "ply" / "frame-000009.ply").mode == "mip"
    evaluation = open_evaluation(path)
    *_, last = evaluation.frames()
    frame = evaluation.trained_clip.read_frame(9)
    over_black = draw_on_cpu(*at, DrawOptions(near, "mip")).bytes
    assert last.psnr == psnr(over_black / 255.0, frame.image / 255.0, frame.evaluation_mask)


@pytest.mark.gl
def test_the_renderers_agree(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    pictures = {}
    for renderer in ("cpu", "gl", "reference"):
        out = tmp_path / renderer
        call = vesselsplat("render", runs["original"], "--out", out, "--time", "0.35", "--with", renderer)
        assert (call.code, call.error) == (0, "")
        pictures[renderer] = cv2.imread(str(out / "time-0.3500.png")).astype(int)
        assert read_provenance(out / "time-0.3500.png")["renderer"]
    for renderer in ("cpu", "gl"):
        assert np.percentile(np.abs(pictures[renderer] - pictures["reference"]), 99.9) <= 1


@pytest.mark.gl
@pytest.mark.parametrize(("precision", "least"), [("half", 60.0), ("float", 75.0)])
def test_opengl_is_as_exact_as_the_trainer_on_a_trained_run(
    ctx: moderngl.Context, runs: dict[str, Path], precision: Precision, least: float
) -> None:
    """At the clip's own frames and between them; `draw_agreement` says the same of runs of full size."""
    run = RunFolder(runs["original"])
    record, model = run.record(), run.model()
    camera = record.cameras[0]
    near = near_plane(model, camera)
    for time in (record.time(1), record.time(9), 0.47):
        splats = model.at(time)
        wanted = exact(splats, camera, near)
        away = render_offscreen(ctx, splats, camera, precision=precision, near=near) - wanted
        assert -10 * np.log10(np.mean(away**2)) >= least
        assert np.quantile(np.abs(away), 0.999) <= 1 / 255
        assert wanted.std() > 0.05


@pytest.mark.gl
def test_what_opengl_cannot_hold_is_refused_in_a_line() -> None:
    draw = drawer("gl").draw
    with pytest.raises(UserError, match="40000x2"):
        draw(model_of(3).at(0.0), Camera.from_fov(60.0, 40_000, 2), DrawOptions(0.01, "default"))


def test_render_takes_another_camera_and_size(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    camera = RunFolder(runs["original"]).record().cameras[0]
    file = tmp_path / "camera.json"
    file.write_text(json.dumps(camera.to_json()))
    flags = ("--frames", 3, "--camera", file, "--size", 32, 24)
    assert vesselsplat("render", runs["original"], "--out", tmp_path / "out", *flags).code == 0
    path = tmp_path / "out" / "frame-000003.png"
    assert cv2.imread(str(path)).shape == (24, 32, 3)
    assert read_provenance(path)["camera"] == camera.resized(32, 24).to_json()


@pytest.mark.parametrize("renderer", ["cpu", "reference", pytest.param("gl", marks=pytest.mark.gl)])
def test_seen_from_beside_it_ends_where_the_frames_do(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, renderer: Renderer
) -> None:
    run, file = runs["original"], tmp_path / "camera.json"
    own = RunFolder(run).record().cameras[0]
    far = FreeView.of(own).flown(0, 0, -2 * open_scene(run).distance).camera
    file.write_text(json.dumps(far.to_json()))
    seen = {}
    for flags in ((), ("--unobserved",)):
        out = tmp_path / str(len(flags))
        given = ("--frames", 3, "--camera", file, "--with", renderer, *flags)
        assert vesselsplat("render", run, "--out", out, *given).code == 0
        image = out / "frame-000003.png"
        assert read_provenance(image)["unobserved"] == bool(flags)
        assert replay(image, (run,), tmp_path / "again.png").difference.is_none
        (tmp_path / "again.png").unlink()
        seen[bool(flags)] = cv2.imread(str(image)).astype(int)
    grey = (np.array(GREY)[::-1] * 255).round()
    drawn = {beyond: (image != grey).any(axis=2) for beyond, image in seen.items()}
    differ = (np.abs(seen[False] - seen[True]) > 2).any(axis=2)
    assert (~drawn[False])[differ].mean() > 0.3
    # Its edge is even, over a pixel on either side.
    near = cv2.dilate(drawn[True].astype(np.uint8), np.ones((3, 3))) > 0
    assert not (drawn[False] & ~near).any()


def test_a_camera_that_moves_has_no_one_frame_to_end_at(runs: dict[str, Path]) -> None:
    scene = open_scene(runs["original"])
    aside = FreeView.of(scene.cameras[0]).flown(0, 0, -scene.distance).camera
    assert ViewRequest(scene, 0.0, aside).within == scene.cameras[0]
    assert ViewRequest(scene, 0.0, aside, unobserved=True).within is None
    assert ViewRequest.of_frame(scene, 2).within is None
    moves = replace(scene, cameras=(aside, *scene.cameras[1:]))
    assert ViewRequest(moves, 0.0, aside).within is None


def test_gaussians_behind_tissue_are_left_out_where_the_endoscope_never_was(runs: dict[str, Path]) -> None:
    scene = open_scene(runs["original"])
    aside = ViewRequest(scene, 0.0, FreeView.of(scene.cameras[0]).flown(0, 0, -scene.distance).camera)
    assert scene.shown_so_far is None
    assert aside.so_far == replace(aside, unobserved=True)
    for _ in scene.find_shown():
        pass
    assert aside.so_far is aside
    known = scene.shown_so_far
    assert known is not None
    assert known is scene.shown
    assert np.array_equal(known, replace(scene).shown)
    assert 0.5 < known.mean() < 1
    every = scene.model.at(0.0).opacities
    assert np.array_equal(aside.splats.opacities, np.where(known, every, 0))
    own = ViewRequest.of_frame(scene, 0)
    for other in (own, replace(own, camera=own.camera.fitted(200, 50)), replace(aside, unobserved=True)):
        assert np.array_equal(other.splats.opacities, every)
    assert not aside.of_kind("points").leaves_out
    assert replace(scene, live=True).shown is None


def test_what_frames_show_is_no_part_of_how_long_a_view_takes(
    runs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which view is drawn smaller, and by what, is chosen by that."""
    clock = [0.0]

    def slow_looks(model: DynamicGaussians, *_: object) -> Iterator[BoolArray]:
        clock[0] += 60
        yield np.ones(len(model), bool)

    monkeypatch.setattr(scene_module, "looks", slow_looks)
    monkeypatch.setattr(drawer_module, "perf_counter", lambda: clock[0])
    scene = open_scene(runs["original"])
    view = ViewRequest(scene, 0.0, FreeView.of(scene.cameras[0]).flown(0, 0, -scene.distance).camera)
    (drawn,) = draw_view(view)
    assert clock == [60]
    assert drawn.milliseconds == 0
    list(draw_view(ViewRequest.of_frame(replace(scene), 0)))
    assert clock == [60]


def test_what_frames_show_is_known_of_an_edited_run_and_of_one_that_is_tinted(runs: dict[str, Path]) -> None:
    """Without looking at all frames after each edit, or with each Gaussian that is selected."""
    scene = open_scene(runs["original"])
    every, some = Edits.none(len(scene.model)), Mask.of(np.arange(len(scene.model)) % 3 == 0)
    selected = every.selecting(some, "replace")
    tinted, edited = tinted_model(scene, selected), scene.edited(selected.deleting())
    assert tinted is not None
    assert tinted.shown_so_far is edited.shown_so_far is None
    for _ in edited.find_shown():
        pass
    known = scene.shown_so_far
    assert known is not None
    both = tinted_model(edited, selected.deleting().selecting_all())
    assert both is not None
    left = known[np.arange(len(known)) % 3 > 0]
    for one, expected in ((tinted, known), (edited, left), (both, left)):
        assert one.shown_so_far is one.shown
        assert np.array_equal(one.shown, expected)


@pytest.mark.parametrize(("size", "where"), [((96, 24), "beside"), ((24, 48), "above and below")])
def test_a_size_of_another_shape_shows_more_and_stretches_nothing(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, size: tuple[int, int], where: str
) -> None:
    """What the clip's camera sees is in the middle, as it is drawn alone."""
    own = RunFolder(runs["original"]).record().cameras[3]
    scale = min(size[0] / own.width, size[1] / own.height)
    inner = (round(scale * own.width), round(scale * own.height))
    pictures = []
    for place, (width, height) in enumerate((size, inner)):
        out = tmp_path / str(place)
        call = vesselsplat("render", runs["original"], "--frames", 3, "--size", width, height, "--out", out)
        assert call.code == 0
        assert (where in call.error) == ((width, height) == size)
        pictures.append(cv2.imread(str(out / "frame-000003.png")).astype(int))
    left, top = (size[0] - inner[0]) // 2, (size[1] - inner[1]) // 2
    middle = pictures[0][top : top + inner[1], left : left + inner[0]]
    assert np.abs(middle - pictures[1]).max() <= 1
    assert pictures[0].shape == (size[1], size[0], 3)


def test_splats_of_a_file_keep_their_shape_in_any_size(tmp_path: Path, vesselsplat: Cli) -> None:
    """A ball is as wide as it is high, and all of it is seen."""
    ball = replace(
        gaussians(1),
        means=np.zeros((1, 3), np.float32),
        log_scales=np.zeros((1, 3), np.float32),
        opacity_logits=np.full(1, 9, np.float32),
        colors=np.ones((1, 3), np.float32),
    )
    (tmp_path / "ball.ply").write_bytes(ply_bytes(ball))
    for width, height in ((200, 60), (60, 200), (100, 100)):
        out = tmp_path / f"{width}x{height}"
        call = vesselsplat("render", tmp_path / "ball.ply", "--size", width, height, "--out", out)
        assert (call.code, call.error) == (0, "")
        bright = cv2.imread(str(out / "frame-000000.png"))[..., 0] > 100
        across, down = np.ptp(np.flatnonzero(bright.any(0))) + 1, np.ptp(np.flatnonzero(bright.any(1))) + 1
        assert abs(int(across) - int(down)) <= 1
        assert 10 < across < min(width, height)


@pytest.mark.parametrize("renderer", ["cpu", "reference", pytest.param("gl", marks=pytest.mark.gl)])
def test_straight_alpha_lies_over_any_background_as_if_drawn_there(renderer: Renderer) -> None:
    camera = turned_camera(96, 80)
    splats = random_splats(150, camera, 3, sigma=(2.0, 9.0))
    draw = drawer(renderer).draw
    picture = draw(splats, camera, DrawOptions(0.01, "default")).straight.astype(float) / 255
    color, alpha = picture[..., :3], picture[..., 3:]
    assert (alpha == 0).any()
    assert np.mean((alpha > 0.02) & (alpha < 0.98)) > 0.3
    for background in ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.1, 0.9, 0.3)):
        over = alpha * color + (1 - alpha) * np.array(background)
        assert np.abs(over - render(splats, camera, background).image).max() <= 1.01 / 255


@pytest.mark.parametrize("name", BACKGROUNDS)
def test_what_was_not_observed_is_told_by_the_background(
    name: BackgroundName, runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = ("--frames", 3, "--size", 32, 24, "--background", name)
    assert vesselsplat("render", runs["original"], "--out", tmp_path / "out", *flags).code == 0
    path = tmp_path / "out" / "frame-000003.png"
    run = RunFolder(runs["original"])
    record, model = run.record(), run.model()
    camera = record.cameras[3].resized(32, 24)
    drawn = draw_on_cpu(model.at(record.time(3)), camera, DrawOptions(near_plane(model, camera)))
    assert np.array_equal(cv2.imread(str(path))[..., ::-1], over(drawn, BACKGROUNDS[name]))
    assert vesselsplat("replay", path, "--source", runs["original"]).code == 0


def test_a_transparent_picture_has_straight_alpha(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = ("--frames", 3, "--size", 32, 24, "--transparent")
    assert vesselsplat("render", runs["original"], "--out", tmp_path / "out", *flags).code == 0
    path = tmp_path / "out" / "frame-000003.png"
    assert read_provenance(path)["background"] is None
    run = RunFolder(runs["original"])
    record, model = run.record(), run.model()
    camera = record.cameras[3].resized(32, 24)
    drawn = draw_on_cpu(model.at(record.time(3)), camera, DrawOptions(near_plane(model, camera)))
    stored = cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), cv2.COLOR_BGRA2RGBA)
    assert np.array_equal(stored, drawn.straight)


@pytest.mark.parametrize(
    ("flags", "word"),
    [
        (("--frames", "10"), "from 0 to 9"),
        (("--frames", "some"), "--frames"),
        (("--time", "1.5"), "--time"),
        (("--time", "0.5", "--frames", "1"), "--time"),
        (("--frames-per-second", "3"), "--frames-per-second: expected --path"),
        (("--transparent", "--background", "smooth"), "--background smooth: expected none"),
        (("--size", "0", "5"), "--size"),
        (("--size", "16384", "16384"), "expected at most 80000000 pixels (VESSELSPLAT_MOST_PIXELS"),
        (("--size", "8000", "8000", "--supersampling", "4", "--frames", "0"), "supersampling"),
        (("--size", "40", "40", "--view", "difference"), "the shape of the frames"),
        (("--size", "100000", "100000"), "1 to 16384"),
        (("--camera", "{tmp}/huge.json"), "1 to 16384"),
        (("--camera", "{tmp}/infinite.json"), "infinite.json"),
        (("--camera", "{tmp}/none.json"), "none.json"),
        (("--camera", "{tmp}/text.json"), "text.json"),
    ],
)
def test_render_refuses_what_a_run_does_not_have(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, flags: tuple[str, ...], word: str
) -> None:
    camera = Camera.from_fov(60, 32, 24).to_json()
    texts = {
        "text": '{"fx": 3}',
        "huge": json.dumps(camera | {"width": 100_000}),
        "infinite": json.dumps(camera | {"width": float("inf")}),
    }
    for name, text in texts.items():
        (tmp_path / f"{name}.json").write_text(text)
    filled = [flag.format(tmp=tmp_path) for flag in flags]
    call = vesselsplat("render", runs["original"], "--out", tmp_path / "out", *filled)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert word in call.error
    assert {path.stem for path in tmp_path.iterdir()} == set(texts)


def test_a_folder_of_exported_splats_is_the_run_through_time(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    """Through the clip's cameras every moment is what the run itself is then."""
    folder, cameras = tmp_path / "splats", tmp_path / "cameras.json"
    flags = ("--ply", folder, "--cameras", cameras, "--frames", "0", "4", "9")
    assert vesselsplat("export", runs["original"], *flags).code == 0
    (folder / "notes.txt").write_text("of the exporter")
    told = json.loads(vesselsplat("info", folder, "--json").out)
    assert told["what"] == {"kind": "splat series"}
    assert told["files"] == {"count": 3}
    camera = tmp_path / "camera.json"
    camera.write_text(json.dumps(RunFolder(runs["original"]).record().cameras[0].to_json()))
    for source, frames in ((runs["original"], ("0", "4", "9")), (folder, ("0", "1", "2"))):
        out = tmp_path / f"of-{source.name}"
        call = vesselsplat("render", source, "--out", out, "--frames", *frames, "--camera", camera)
        assert call.code == 0, call.error
    both = [sorted((tmp_path / f"of-{name}").glob("*.png")) for name in (runs["original"].name, "splats")]
    for own, again in zip(*both, strict=True):
        assert np.abs(cv2.imread(own).astype(int) - cv2.imread(again)).max() <= 1
    assert vesselsplat("replay", both[1][1], "--source", folder).code == 0
    refused = vesselsplat("render", folder, "--out", tmp_path / "none", "--view", "motion")
    assert (refused.code, refused.error.count("\n")) == (2, 1)
