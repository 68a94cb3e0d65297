"""A folder that is deleted, or unplugged, while an export is written into it: said with the next frame."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from app.errors import UserError
from app.files.timing import Timing
from app.files.video import write_video

COUNT, GONE = 90, 70
"""Frames, and that in which the folder is gone: the encoder has written some by then."""


def test_a_video_ends_with_the_frame_in_which_its_folder_is_gone(tmp_path: Path) -> None:
    """Its open file could be written on to the last of its frames."""
    folder, drawn = tmp_path / "stick", list[int]()

    def frames() -> Iterator[np.ndarray]:
        for index in range(COUNT):
            if index == GONE:
                shutil.rmtree(folder)
            drawn.append(index)
            yield np.full((48, 64, 3), 2 * index, np.uint8)

    with pytest.raises(UserError) as caught:
        write_video(folder / "scope.mp4", frames(), Timing(25.0))
    assert str(caught.value) == (
        f"expected the folder to stay while a file is written into it, got it gone: {folder}"
    )
    assert drawn == [*range(GONE + 1)]
    assert not folder.exists()
