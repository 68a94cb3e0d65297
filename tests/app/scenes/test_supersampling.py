"""Pictures drawn larger and averaged: what is averaged, and that it is what the pixel's area shows."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from app.files.provenance import read_provenance
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from app.scenes.supersampling import FACTORS, averaged, supersampled
from renderer.camera import Camera
from renderer.rasterize.rendered import Rendered
from renderer.splats import Shape, Splats
from tests.app.conftest import Cli
from tests.app.gui.conftest import make_model


def test_a_drawing_is_averaged_before_it_is_clipped() -> None:
    """A drawer whose picture is known: values above 1 count in full, pixels lie where they are."""

    def ramp(splats: Splats, camera: Camera, options: DrawOptions) -> Rendered:
        x = (np.arange(camera.width, dtype=np.float32) + 0.5) / camera.width * 3
        image = np.broadcast_to(x[None, :, None], (camera.height, camera.width, 3)).copy()
        alpha = np.ones(image.shape[:2], np.float32)
        return Rendered(image, alpha, alpha)

    camera, splats = Camera.from_fov(60, 6, 4), make_model().at(0)
    plain = ramp(splats, camera, DrawOptions(1.0, "default"))
    for factor in FACTORS:
        drawn = supersampled(ramp, factor)(splats, camera, DrawOptions(1.0, "default"))
        np.testing.assert_allclose(drawn.image, plain.image, rtol=1e-6)
        assert drawn.image.max() > 1


def test_depth_and_colour_count_by_how_much_is_seen() -> None:
    alpha = np.array([[1.0, 0.25], [0.0, 0.0]], np.float32)
    depth = np.array([[10.0, 50.0], [0.0, 0.0]], np.float32)
    image = np.repeat((alpha * 0.5)[..., None], 3, axis=2)
    one = averaged(Rendered(image, alpha, depth), 2)
    assert one.alpha.shape == (1, 1)
    np.testing.assert_allclose(one.depth, (10 + 0.25 * 50) / 1.25)
    # The straight colour of what is seen stays 0.5; nothing of the black background gets into it.
    np.testing.assert_allclose(one.image / one.alpha[..., None], 0.5)
    empty = averaged(Rendered(np.zeros((2, 2, 3), np.float32), alpha * 0, np.zeros((2, 2), np.float32)), 2)
    assert np.isfinite(empty.depth).all()


@pytest.mark.parametrize("shape", ["soft", "point"])
def test_more_samples_converge(shape: Shape) -> None:
    """Each doubling comes nearer to the mean over the pixel's area."""
    splats, camera = make_model().at(0), Camera.from_fov(60, 24, 20)
    finest = supersampled(draw_on_cpu, 16)(splats, camera, DrawOptions(1.0, "default", shape)).image
    apart = [
        np.abs(
            supersampled(draw_on_cpu, factor)(splats, camera, DrawOptions(1.0, "default", shape)).image
            - finest
        ).mean()
        for factor in (1, 2, 4)
    ]
    assert apart[0] > 1.5 * apart[1] > 2 * apart[2] > 0


def test_commands_draw_finer_and_say_so(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    run = runs["original"]
    flags = ("--frames", 3, "--depth", "--view", "normals")
    for factor in (1, 4):
        out = tmp_path / str(factor)
        assert vesselsplat("render", run, "--out", out, *flags, "--supersampling", factor).code == 0
        for name in ("frame-000003.png", "frame-000003-depth.npy"):
            call = vesselsplat("replay", out / name, "--source", run)
            assert (call.code, call.error) == (0, "")
    assert read_provenance(out / "frame-000003.png")["supersampling"] == 4
    plain, fine = (cv2.imread(str(tmp_path / name / "frame-000003.png")) for name in ("1", "4"))
    assert plain.shape == fine.shape
    assert not np.array_equal(plain, fine)
    video = tmp_path / "fine.mp4"
    assert vesselsplat("export", run, "--video", video, "--frames", 2, 3, "--supersampling", 2).code == 0
    assert vesselsplat("replay", video, "--source", run).code == 0
    call = vesselsplat("render", run, "--out", out, "--size", 9000, 10, "--supersampling", 2)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "--supersampling" in call.error
