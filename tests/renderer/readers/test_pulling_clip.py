"""The EndoNeRF clip of pulled tissue as it is in the wild, where it lies beside the repository."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.clip import ClipError
from renderer.readers.clip_options import ClipOptions
from renderer.readers.data_sets.endonerf import open_endonerf

PULLING = Path(__file__).resolve().parents[3] / "../shared/data/endonerf/pulling_soft_tissues"
pytestmark = [
    pytest.mark.data,
    pytest.mark.skipif(not PULLING.is_dir(), reason="the pulling clip is not there"),
]


def test_the_pulling_clip():
    clip = open_endonerf(PULLING)
    assert (len(clip), clip.size, clip.has_depth) == (63, (640, 512), True)
    assert clip.camera_is_fixed
    assert clip.cameras[0].fx == pytest.approx(569.46820041)
    assert clip.test_indices == (1, 9, 17, 25, 33, 41, 49, 57)
    frame = clip.read_frame(48)  # A 16-bit depth among 8-bit ones.
    assert frame.depth is not None
    assert frame.depth.max() == 101  # The file's 392 is a failed match.
    assert not frame.tissue_mask[-12:].any()
    assert frame.tissue_mask[-13].any()
    assert not frame.depth[~frame.tissue_mask].any()
    assert 0 < (frame.evaluation_mask & (frame.depth == 0))[:-12].sum() < 100
    without_depth = (frame.tissue_mask & ~frame.depth_mask).mean()
    assert 0.05 < without_depth < 0.08, "tissue that stereo misses is trained on"
    tools_only = open_endonerf(PULLING, ClipOptions(evaluation_masks="gt_masks")).read_frame(48)
    assert (tools_only.evaluation_mask & ~frame.evaluation_mask).any()


def test_the_pulling_clip_inverted_is_refused(tmp_path):
    for name in ("images", "depth"):
        shutil.copytree(PULLING / name, tmp_path / "clip" / name)
    shutil.copy(PULLING / "poses_bounds.npy", tmp_path / "clip")
    (tmp_path / "clip/masks").mkdir()
    for path in (PULLING / "masks").glob("*.png"):
        Image.fromarray(255 - np.asarray(Image.open(path))).save(tmp_path / "clip/masks" / path.name)
    with pytest.raises(ClipError, match="look as if they mark tissue"):
        open_endonerf(tmp_path / "clip").read_frame(0)
