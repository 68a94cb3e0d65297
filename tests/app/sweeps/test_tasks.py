"""What is done in one job."""

from __future__ import annotations

from pathlib import Path

import cv2

from app.files.provenance import digest, read_provenance
from app.sweeps.jobs import PICTURE, Job, Keeps
from app.sweeps.settings import settings_of
from app.sweeps.tasks import carry_out
from tests.app.enhancement.test_batch import write_avi


def test_a_video_is_read_and_measured_as_the_settings_say(tmp_path: Path) -> None:
    clip = tmp_path / "a.avi"
    write_avi(clip)
    levels = {}
    for scope in ("image", "clip"):
        out = tmp_path / scope
        out.mkdir()
        settings = settings_of("enhance", {"stereo": "side-by-side", "statistics": scope})
        measures = carry_out(Job("enhance", clip.name, digest(clip), settings, 2), clip, out, Keeps())
        assert measures["images"] == 2
        assert cv2.imread(str(out / PICTURE)).shape == (48, 32, 3)
        record = read_provenance(out / PICTURE)
        assert record["stereo"] == "side-by-side"
        levels[scope] = record["statistics"]["level"]
    assert levels["image"] != levels["clip"]
