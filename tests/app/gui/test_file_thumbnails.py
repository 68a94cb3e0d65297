"""Thumbnails of videos, as the file dialog shows them."""

from __future__ import annotations

from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from app.gui.work.listing import thumbnail_of
from renderer.sources import open_clip


def test_a_video_has_a_thumbnail_without_pyav(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.gui.work.listing.has_pyav", lambda: False)
    writer = cv2.VideoWriter(str(tmp_path / "scope.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for _ in range(5):
        writer.write(np.full((48, 64, 3), (0, 0, 200), np.uint8))
    writer.release()
    (image,) = thumbnail_of(tmp_path / "scope.mp4")
    assert image is not None
    assert np.abs(image.reshape(-1, 3).mean(axis=0) - (200, 0, 0)).max() < 12


def test_a_thumbnail_is_upright_as_the_clip_will_be(tmp_path: Path) -> None:
    path = tmp_path / "phone.mov"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=10)
        stream.width, stream.height, stream.pix_fmt = 64, 32, "yuv420p"
        stream.set_display_rotation(90)
        for _ in range(5):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.full((32, 64, 3), 90, np.uint8))))
        container.mux(stream.encode())
    (image,) = thumbnail_of(path)
    assert image is not None
    assert image.shape[:2] == open_clip(path).size[::-1] == (64, 32)
