"""A video that nobody holds any more holds nothing itself."""

from __future__ import annotations

import gc
import sys
from pathlib import Path

import psutil
import pytest

from renderer.readers.video import open_video
from tests.renderer.readers.numbered import opencv_video


@pytest.mark.parametrize(("name", "code"), [("a.mp4", "mp4v"), ("b.avi", "MJPG"), ("c.mkv", "mp4v")])
@pytest.mark.skipif(sys.platform == "win32", reason="counts what the process holds open by name")
def test_a_dropped_video_lets_its_decoder_go_without_a_search_for_garbage(
    tmp_path: Path, name: str, code: str
) -> None:
    """Its container and streams hold each other, and such a search may never come: see `gc.freeze`."""

    video = opencv_video(tmp_path / name, code, 100)

    def held() -> int:
        return sum(one.path == str(video) for one in psutil.Process().open_files())

    gc.disable()
    try:
        clip = open_video(video)
        clip.read_image(90), clip.read_image(5)
        assert held() == 1
        del clip
        assert held() == 0
    finally:
        gc.enable()
