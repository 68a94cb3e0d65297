"""A model as one HTML file: its numbers are the model's, it needs no network, and it is reproduced."""

from __future__ import annotations

import json
import re
import tracemalloc
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.browser.of_scene import browser_model
from app.exports.browser.page import PageWindow, browser_page, read_page
from app.exports.browser.samples import USUAL
from app.exports.browser.tracks import CUBIC, LINEAR, Tracks, tracks_of
from app.exports.make import make
from app.exports.records import BrowserModel
from app.exports.sources import Opened
from app.files.stepping import run_to_end
from app.scenes.free_camera import FreeView
from app.scenes.scene import open_scene
from renderer.camera import Camera
from renderer.deformation.motion import Still
from renderer.deformation.spline import spline_taps
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from tests.app.conftest import Cli

CAMERA = Camera(fx=50, fy=50, cx=16, cy=12, width=32, height=24)
COUNT, CONTROLS = 40, 7


def raw(random: np.random.Generator) -> RawGaussians:
    def drawn(*shape: int) -> NDArray[np.float32]:
        return random.normal(size=(COUNT, *shape)).astype(np.float32)

    return RawGaussians(
        means=drawn(3) + np.float32([0, 0, 9]),
        quats=drawn(4),
        log_scales=drawn(3) - 3,
        opacity_logits=drawn(),
        colors=drawn(3),
        harmonics=np.zeros((COUNT, 0, 3), np.float32),
    )


def spline(
    random: np.random.Generator, *, moving: int, colored: int, fading: int, nodes: bool
) -> SplineMotion:
    """Rows of each channel, as training leaves some of them out."""

    def curves(count: int, channels: int = 3) -> NDArray[np.float32]:
        return random.normal(size=(count, CONTROLS, channels)).astype(np.float32)

    weights = random.random((COUNT if nodes else 0, 4)).astype(np.float32)
    return SplineMotion(
        position_controls=curves(moving),
        color_controls=curves(colored),
        opacity_controls=curves(fading, 1),
        node_controls=curves(9),
        node_indices=random.integers(0, 9, weights.shape, dtype=np.int32),
        node_weights=weights / weights.sum(axis=1, keepdims=True) if nodes else weights,
    )


def shown(model: DynamicGaussians, time: float) -> dict[str, NDArray[np.float64]]:
    """What the page draws, by its own rules, written out in numpy."""
    return drawn(tracks_of(model), time)


def drawn(tracks: Tracks, time: float) -> dict[str, NDArray[np.float64]]:
    """The same of what the page holds."""
    found = {}
    for track, told in zip(tracks.tracks, tracks.told(), strict=True):
        whole = np.frombuffer(
            tracks.content,
            "f4" if told["bytes"] == 4 else f"u{told['bytes']}",
            told["count"] * told["moments"] * told["channels"],
            told["start"],
        )
        top = 1 if told["bytes"] == 4 else 256 ** told["bytes"] - 1
        span = np.subtract(told["high"], told["low"]) / top
        values = (
            np.array(told["low"]) + whole.reshape(told["count"], told["moments"], told["channels"]) * span
        )
        if told["moments"] == 1:
            found[track.name] = values[:, 0]
        elif tracks.degree == CUBIC:
            first, weights = spline_taps(time, told["moments"])
            found[track.name] = np.einsum("t,ntc->nc", weights, values[:, first : first + 4])
        else:
            place = time * (told["moments"] - 1)
            first = min(int(place), told["moments"] - 2)
            found[track.name] = values[:, first] + (place - first) * (values[:, first + 1] - values[:, first])
    return found


@pytest.mark.parametrize("time", [0.0, 0.31, 1.0])
@pytest.mark.parametrize(
    "channels",
    [
        {"moving": COUNT, "colored": COUNT, "fading": COUNT, "nodes": True},
        {"moving": 0, "colored": COUNT, "fading": 0, "nodes": True},
        {"moving": COUNT, "colored": 0, "fading": 0, "nodes": False},
        {"moving": 0, "colored": 0, "fading": 0, "nodes": False},
    ],
)
def test_the_page_has_the_models_values_to_a_step_of_its_numbers(
    channels: dict[str, Any], time: float
) -> None:
    random = np.random.default_rng(3)
    model = DynamicGaussians(raw(random), spline(random, **channels))
    moved, page = model.motion.moved(model.raw, time), shown(model, time)
    steps = {
        one.name: (one.high - one.low) / (255 if one.values.itemsize == 1 else 65535)
        for one in tracks_of(model).tracks
    }
    for name, values in (
        ("means", moved.means),
        ("colors", moved.colors),
        ("log_scales", moved.log_scales),
        ("opacity_logits", moved.opacity_logits[:, None]),
    ):
        assert (np.abs(page[name] - values) <= 0.51 * steps[name] + 1e-5).all(), name
    length = np.linalg.norm(moved.quats, axis=1, keepdims=True)
    apart = np.abs((page["quats"] * moved.quats / length).sum(axis=1))
    assert apart == pytest.approx(1, abs=1e-4)


def test_what_does_not_move_takes_one_value_and_what_has_no_curves_is_sampled() -> None:
    random = np.random.default_rng(4)
    still = tracks_of(DynamicGaussians(raw(random), Still()))
    assert still.degree == LINEAR
    assert {track.name: track.values.shape[1] for track in still.tracks} == dict.fromkeys(
        ("means", "colors", "quats", "log_scales", "opacity_logits"), 1
    )
    motion = spline(random, moving=COUNT, colored=0, fading=0, nodes=False)

    class Sampled:
        """A motion of another kind."""

        def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
            return motion.moved(raw, time)

    model = DynamicGaussians(raw(random), Sampled())  # type: ignore[arg-type]
    moments = {track.name: track.values.shape[1] for track in tracks_of(model).tracks}
    assert (moments["means"], moments["colors"]) == (USUAL, 1)
    page, moved = shown(model, 0.5), motion.moved(model.raw, 0.5)
    assert np.abs(page["means"] - moved.means).max() < 0.05


def test_a_turn_whose_quaternion_would_change_its_sign_goes_on_between_samples() -> None:
    one = raw(np.random.default_rng(6))

    class Turning:
        """Through w = 0, at the middle."""

        def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
            half = np.float32(np.pi / 2 + 0.4 * (time - 0.5))
            quat = np.array([np.cos(half), 0.6 * np.sin(half), 0.8 * np.sin(half), 0], np.float32)
            return replace(raw, quats=np.broadcast_to(quat, raw.quats.shape))

    model = DynamicGaussians(one, Turning())  # type: ignore[arg-type]
    for time in (0.45, 0.5, 0.503):
        page, true = shown(model, time), model.motion.moved(one, time).quats
        length = np.linalg.norm(page["quats"], axis=1)
        assert np.abs((page["quats"] * true).sum(axis=1)) / length == pytest.approx(1, abs=1e-4)


def test_a_still_model_takes_little_memory_a_gaussian() -> None:
    """Of a million, a page is written where the model itself can be opened."""
    one, many = raw(np.random.default_rng(8)), 100_000
    arrays = {name: np.resize(array, (many, *array.shape[1:])) for name, array in one.arrays().items()}
    model = DynamicGaussians(RawGaussians(**arrays), Still())
    tracemalloc.start()
    try:
        tracks_of(model)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak / many < 300


def record_of(title: str, frames: int, seconds: float = 1.0) -> BrowserModel:
    return BrowserModel(title=title, camera=CAMERA, near=0.01, clip_frames=frames, seconds=seconds)


def test_the_page_stands_alone_and_names_cannot_break_it() -> None:
    random = np.random.default_rng(5)
    model = DynamicGaussians(raw(random), Still())
    title = "</script><img src=x onerror=alert(1)>"
    windows = [PageWindow(tracks_of(model), 0, 4)]
    text = browser_page(windows, record_of(title, 5, 2.0), "default", about="a & b").decode()
    assert not re.search(r"https?://|<link|src=[\"']", text.replace("&lt;img src=x", ""))
    assert text.count("</script>") == 4
    assert "&lt;/script&gt;" in text
    assert "a &amp; b" in text
    facts, scene, content = read_page(text)
    assert facts["title"] == title
    assert (scene["frames"], scene["seconds"], scene["camera"]["width"]) == (5, 2.0, 32)
    assert content.tobytes() == tracks_of(model).content


def test_a_long_clip_is_one_page_whose_camera_goes_with_it(
    vesselsplat: Cli, windowed_run: Path, tmp_path: Path
) -> None:
    scene, page = open_scene(windowed_run), tmp_path / "model.html"
    written = vesselsplat("export", windowed_run, "--html", page)
    assert written.code == 0, written.error
    _, said, content = read_page(page.read_text())
    assert [(one["first"], one["last"]) for one in said["windows"]] == [(0, 47), (32, 79), (64, 111)]
    assert [one["shown"] for one in said["windows"]] == [[-1, 40], [39, 72], [71, 112]]
    assert sum(one["tracks"][0]["count"] for one in said["windows"]) == len(scene.model)
    ends = [track["start"] + track["count"] * track["moments"] * track["channels"] * track["bytes"]
            for one in said["windows"] for track in one["tracks"]]  # fmt: skip
    assert len(content) - ends[-1] in range(4)
    assert np.allclose(said["poses"], [np.asarray(one.camera_from_world)[:3] for one in scene.cameras])
    assert "lenses" not in said
    again = vesselsplat("replay", page, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    of_one = vesselsplat("export", windowed_run, "--window", 2, "--html", tmp_path / "two.html")
    assert of_one.code == 0, of_one.error
    _, said, _ = read_page((tmp_path / "two.html").read_text())
    assert [(one["first"], one["last"]) for one in said["windows"]] == [(0, 47)]


def test_a_lens_that_zooms_does_so_in_the_page(runs: dict[str, Path], tmp_path: Path) -> None:
    scene, page = open_scene(runs["original"]), tmp_path / "model.html"
    longer = tuple(replace(one, fx=one.fx * (1 + 0.1 * n)) for n, one in enumerate(scene.cameras))
    zooming = replace(scene, cameras=longer)
    record = browser_model(zooming, longer[1], 25.0)
    assert record.moves
    run_to_end(make(record, Opened(model=zooming), page))
    _, said, _ = read_page(page.read_text())
    assert said["lenses"] == [list(one.lens) for one in longer]
    run_to_end(make(replace(record, zooms=False), Opened(model=zooming), page))
    assert "lenses" not in read_page(page.read_text())[1], "a page of before 0.13.0 has one lens"


def test_the_page_numbers_its_frames_as_the_clip(
    vesselsplat: Cli, windowed_run: Path, tmp_path: Path
) -> None:
    page = tmp_path / "two.html"
    done = vesselsplat("export", windowed_run, "--window", 2, "--html", page)
    assert done.code == 0, done.error
    text = page.read_text()
    facts, said, _ = read_page(text)
    assert (said["start"], said["frames"], facts["start"]) == (32, 48, 32)
    assert "`frame ${start + frame + 1} / ${start + scene.frames}`" in text
    again = vesselsplat("replay", page, "--source", windowed_run)
    assert again.out.rstrip().endswith("identical"), again.error + again.out
    whole = tmp_path / "all.html"
    assert vesselsplat("export", windowed_run, "--html", whole).code == 0
    facts, said, _ = read_page(whole.read_text())
    assert "start" not in said | facts


def test_more_than_a_browser_opens_is_told(
    vesselsplat: Cli, runs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.exports.browser.page.LONGEST", 1000)
    done = vesselsplat("export", runs["original"], "--html", tmp_path / "a.html")
    assert (done.code, "is more than browsers open" in done.error) == (2, True)
    assert not list(tmp_path.iterdir())


def test_a_page_of_a_splat_file_says_that_it_is_one(
    vesselsplat: Cli, runs: dict[str, Path], tmp_path: Path
) -> None:
    vesselsplat("export", runs["original"], "--ply", tmp_path, "--frames", 0)
    told = {
        tmp_path / "frame-000000.ply": "Splat file",
        runs["original"]: "Reconstruction of original frames. Grey: what no frame showed",
    }
    for path, about in told.items():
        page = tmp_path / f"{path.stem}.html"
        assert vesselsplat("export", path, "--html", page).code == 0
        assert f"<p>{about}</p>" in page.read_text()


def test_a_window_without_gaussians_is_an_empty_one() -> None:
    model = DynamicGaussians(raw(np.random.default_rng(7)), Still())
    none = DynamicGaussians(
        RawGaussians(**{name: value[:0] for name, value in model.raw.arrays().items()}), Still()
    )
    windows = [PageWindow(tracks_of(one), first, first) for first, one in enumerate((model, none))]
    _, said, _ = read_page(browser_page(windows, record_of("", 2), "default", about="").decode())
    assert [one["tracks"][0]["count"] for one in said["windows"]] == [COUNT, 0]
    assert said["windows"][1]["tracks"][0]["low"] == [0, 0, 0]


@pytest.mark.parametrize("damage", ["", "<html></html>", "cut", "other"])
def test_another_page_is_refused_in_one_line(damage: str) -> None:
    model = DynamicGaussians(raw(np.random.default_rng(6)), Still())
    windows = [PageWindow(tracks_of(model), 0, 4)]
    text = browser_page(windows, record_of("t", 1), "default", about="").decode()
    cut = re.sub(r'(id="content">.{80}).*?</script>', r"\1</script>", text, flags=re.DOTALL)
    other = re.sub(r'id="content">.*?</script>', 'id="content">!!!</script>', text, flags=re.DOTALL)
    with pytest.raises(UserError, match="expected an HTML file written by VesselSplat"):
        read_page({"cut": cut, "other": other}.get(damage, damage))


def test_a_run_becomes_a_page_that_is_reproduced(
    vesselsplat: Cli, runs: dict[str, Path], tmp_path: Path
) -> None:
    run = runs["original"]
    page = tmp_path / "model.html"
    written = vesselsplat("export", run, "--html", page)
    assert written.code == 0, written.error
    facts, scene, _ = read_page(page.read_text())
    assert facts["kind"] == "browser model"
    assert facts["notice"] == "Research use only. Not a medical device."
    assert str(tmp_path) not in page.read_text()
    assert scene["frames"] == 10
    again = vesselsplat("replay", page, "--source", run)
    assert (again.code, again.out.rstrip().endswith("identical")) == (0, True), again.error + again.out
    assert vesselsplat("export", run, "--html", tmp_path / "model.txt").code == 2


def test_the_page_tells_what_no_frame_shows(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    run, file = runs["original"], tmp_path / "aside.json"
    scene = open_scene(run)
    aside = FreeView.of(scene.cameras[0]).flown(0, 0, -scene.distance).camera
    file.write_text(json.dumps(aside.to_json()))
    told = {}
    for name, flags in (("own", ()), ("aside", ("--camera", file)), ("all", ("--unobserved",))):
        page = tmp_path / f"{name}.html"
        assert vesselsplat("export", run, "--html", page, *flags).code == 0
        _, told[name], _ = read_page(page.read_text())
    assert scene.shown is not None
    for name in ("own", "aside"):
        assert told[name]["hidden"] == np.flatnonzero(~scene.shown).tolist()
        assert np.allclose(told[name]["sides"], scene.cameras[0].sides)
        assert told[name]["free"] == (name == "aside")
    assert not {"hidden", "sides", "free"} & set(told["all"])
