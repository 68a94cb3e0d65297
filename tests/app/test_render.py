"""`vesselsplat render`: the pictures of a run, where each comes from, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.drawers import drawer
from app.drawing import draw_on_cpu
from app.errors import UserError
from app.provenance import read_provenance
from app.run_folder import RunFolder
from renderer.camera import Camera
from renderer.near_plane import near_plane
from tests.app.conftest import Call
from tests.app.fake_steps import model_of

Cli = Callable[..., Call]
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
    drawn = draw_on_cpu(model.at(record.time(9)), record.camera(9), near_plane(model, record.camera(9)))
    assert np.array_equal(cv2.imread(str(out / "frame-000009.png"))[..., ::-1], drawn.bytes)
    assert np.array_equal(np.load(out / "frame-000009-depth.npy"), drawn.depth)
    facts = read_provenance(out / "frame-000009.png")
    assert (facts["frame"], facts["time"]) == (9, record.time(9))
    assert facts["camera"] == record.camera(9).to_json()
    assert str(runs["original"].parent) not in json.dumps(facts)


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
def test_what_opengl_cannot_hold_is_refused_in_a_line() -> None:
    draw, _ = drawer("gl")
    with pytest.raises(UserError, match="40000x2"):
        draw(model_of(3).at(0.0), Camera.from_fov(60.0, 40_000, 2), 0.01)


def test_render_takes_another_camera_and_size(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    camera = RunFolder(runs["original"]).record().camera(0)
    file = tmp_path / "camera.json"
    file.write_text(json.dumps(camera.to_json()))
    flags = ("--frames", 3, "--camera", file, "--size", 32, 24)
    assert vesselsplat("render", runs["original"], "--out", tmp_path / "out", *flags).code == 0
    path = tmp_path / "out" / "frame-000003.png"
    assert cv2.imread(str(path)).shape == (24, 32, 3)
    assert read_provenance(path)["camera"] == camera.resized(32, 24).to_json()


@pytest.mark.parametrize(
    ("flags", "word"),
    [
        (("--frames", "10"), "from 0 to 9"),
        (("--frames", "some"), "--frames"),
        (("--time", "1.5"), "--time"),
        (("--time", "0.5", "--frames", "1"), "--time"),
        (("--size", "0", "5"), "--size"),
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
