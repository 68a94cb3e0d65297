"""Videos of more than 8 bits a colour."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.commands.described.clips import of_video
from renderer.readers.video_header import read_video_header
from renderer.sources import open_clip
from tests.renderer.readers.numbered import encoded


@pytest.mark.parametrize(("pixels", "bits"), [("yuv420p10le", 10), ("yuv420p", 8)])
def test_more_than_8_bits_are_told_and_read_with_8(tmp_path: Path, pixels: str, bits: int) -> None:
    path = encoded(tmp_path / "a.mp4", [np.full((48, 64, 3), 120, np.uint8)] * 3, pixels=pixels)
    clip, header = open_clip(path), read_video_header(path)
    assert header.bits == bits
    assert [f"{bits} bits a colour; it is read with 8" in said for said in clip.notices] == [True] * (
        bits > 8
    )
    assert clip.read_image(1).dtype == np.uint8
    assert np.abs(clip.read_image(1).astype(int) - 120).max() <= 2
    assert [fact.text for fact in of_video(path) if fact.name == "bits"] == (
        [f"{bits} a colour, read with 8"] if bits > 8 else []
    )
