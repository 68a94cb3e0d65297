"""A video that nobody holds any more holds nothing itself."""

from __future__ import annotations

import gc
import os
import sys
from pathlib import Path

import av
import numpy as np
import psutil
import pytest

from renderer.readers.video import open_video
from renderer.readers.video_decoding.decoders import MOST
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


def test_frames_that_were_read_are_let_go_without_a_search_for_garbage(tmp_path: Path) -> None:
    """Each is of megabytes, and such a search waits for many small objects."""
    clip = open_video(opencv_video(tmp_path / "a.mp4", "mp4v", 100))
    clip.read_image(0)
    gc.collect()
    gc.disable()
    try:
        for index in range(40):
            clip.read_image(index)
        assert sum(type(one) is av.VideoFrame for one in gc.get_objects()) < 10
    finally:
        gc.enable()


@pytest.mark.skipif(sys.platform == "win32", reason="counts what the process holds open by name")
def test_of_many_videos_only_the_last_read_hold_a_decoder(tmp_path: Path) -> None:
    """The others decode again where they are read again."""
    video, threads = opencv_video(tmp_path / "a.mp4", "mp4v", 100), psutil.Process().num_threads()
    clips = [open_video(video) for _ in range(3 * MOST)]
    wanted = {index: clips[0].read_image(index) for index in (99, 5, 50)}
    for index, image in wanted.items():
        for clip in clips:
            np.testing.assert_array_equal(clip.read_image(index), image)
    assert sum(one.path == str(video) for one in psutil.Process().open_files()) == MOST
    assert psutil.Process().num_threads() <= threads + MOST * (1 + 2 * (os.cpu_count() or 1))
