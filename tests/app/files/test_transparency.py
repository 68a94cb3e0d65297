"""Images with alpha: what the commands say of them, and what was recorded before."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from pydantic import TypeAdapter

from app.enhancement.enhance_files import Setting, enhance_into
from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import Scope
from app.exports.replay.again import replay
from app.files.image_files import read_image
from app.files.image_series import open_series
from app.files.records import RecordedReading
from app.files.stepping import run_to_end
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.runs.trained_clip import run_clip
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip
from renderer.train.events import Started, Warned
from tests.app.conftest import CONFIG, Cli, request_of, tissue

SAID = "fully transparent pixels count as outside of the tissue"
SHORT = replace(CONFIG, iterations=2, n_gaussians=100)


@pytest.fixture
def images(tmp_path: Path) -> Path:
    """Three, whose left quarter is transparent."""
    (tmp_path / "images").mkdir()
    alpha = np.full((40, 60), 255, np.uint8)
    alpha[:, :15] = 0
    for number in range(3):
        cv2.imwrite(str(tmp_path / f"images/{number}.png"), np.dstack((tissue(number), alpha)))
    return tmp_path / "images"


def test_an_enhanced_png_keeps_its_alpha_and_the_command_says_what_it_means(
    images: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    call = vesselsplat("enhance", images, tmp_path / "out")
    assert (call.code, call.error.count(SAID)) == (0, 1)
    made, given = (read_image(folder / "1.png") for folder in (tmp_path / "out", images))
    np.testing.assert_array_equal(made[..., 3], given[..., 3])
    np.testing.assert_array_equal(made[:, :15], given[:, :15])
    assert not np.array_equal(made[:, 15:], given[:, 15:])
    assert replay(tmp_path / "out/1.png", (images,), tmp_path / "again.png").difference.is_none


def test_what_measures_says_so_of_images_and_not_of_masks(
    images: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    opaque = tmp_path / "opaque.png"
    cv2.imwrite(str(opaque), tissue(1))
    image, size = images / "1.png", ("--vary", "d_factor=0:1:2")
    told = vesselsplat("metrics", image, "--against", image, "--vessels", image)
    assert (told.code, told.error.count(f"{SAID}: {image}")) == (0, 2)
    tuned = vesselsplat("tune", images, *size, "--frame", 1, "--out", tmp_path / "tuned")
    assert (tuned.code, tuned.error.count(SAID)) == (0, 1)
    assert SAID not in vesselsplat("metrics", opaque).error
    assert SAID not in vesselsplat("tune", opaque, *size, "--out", tmp_path / "other").error


def test_a_run_leaves_out_what_is_transparent_and_one_of_before_goes_on_as_it_began(
    images: Path, tmp_path: Path
) -> None:
    request = request_of(images, tmp_path / "run", config=SHORT, clip_options=ClipOptions(depth="brightness"))
    said = [event.message for event in run_training(request) if isinstance(event, Warned)]
    assert sum(SAID in message for message in said) == 1
    run = RunFolder(request.run_path)
    assert not run_clip(run.record()).read_frame(0).tissue_mask[:, :15].any()

    former = replace(request, run_path=tmp_path / "former", config=replace(SHORT, iterations=4))
    events = run_training(replace(former, clip_options=ClipOptions(depth="brightness", alpha="ignored")))
    next(event for event in events if isinstance(event, Started))
    events.close()
    told = json.loads((former.run_path / "run.json").read_text())
    del told["clip"]["options"]["alpha"]
    (former.run_path / "run.json").write_text(json.dumps(told))
    assert run_clip(RunFolder(former.run_path).record()).read_frame(0).tissue_mask.all()
    said = [
        event.message for event in run_training(replace(former, resume=True)) if isinstance(event, Warned)
    ]
    assert not any(SAID in message for message in said)
    assert RunFolder(former.run_path).is_finished


@pytest.mark.parametrize("scope", ["image", "clip"])
@pytest.mark.parametrize("params", [EnhanceParams(), VesselParams()])
def test_the_window_enhances_as_the_command_does(
    images: Path, tmp_path: Path, scope: Scope, params: EnhancementSettings
) -> None:
    setting = Setting("paper" if isinstance(params, EnhanceParams) else "vessel", params, scope)
    run_to_end(enhance_into(tmp_path / "out", open_series(images), setting))
    request = PictureRequest(open_clip(images), 1, params, scope)
    *_, shown = PictureMaker().make(request)
    assert shown.original.shape == (40, 60, 3)
    np.testing.assert_array_equal(shown.enhanced, read_image(tmp_path / "out/1.png")[..., :3])
    former = replace(request, clip=open_clip(images, ClipOptions(alpha="ignored")))
    *_, other = PictureMaker().make(former)
    assert not np.array_equal(other.enhanced, shown.enhanced)


def test_records_of_before_take_all_pixels() -> None:
    read = TypeAdapter(RecordedReading).validate_python
    assert read({"bits": None}).alpha == "ignored"
    assert read({"alpha": None}).alpha is None
