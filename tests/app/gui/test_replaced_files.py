"""The runs of a file that another one has replaced at its place, alone or in a clip's folder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from app.files.image_files import write_image
from app.files.provenance import digest
from app.gui.work.runs import RunFinder
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from tests.app.gui.test_opening import make_run


def test_a_file_that_is_replaced_at_its_place_is_looked_at_anew(
    tmp_path: Path, model: DynamicGaussians
) -> None:
    path, other = tmp_path / "clip.png", tmp_path / "other.png"
    for place, level in ((path, 90), (other, 120)):
        write_image(place, np.full((24, 32, 3), level, np.uint8), {})
    record = make_run(tmp_path / "run", phantom_path(), model).record()
    gone = str(tmp_path / "gone.png")
    record = replace(record, clip=replace(record.clip, path=gone, frames=1, sha256=digest(other)))
    finder = RunFinder()
    assert not finder._is_of(record, open_clip(path))
    other.replace(path)
    assert finder._is_of(record, open_clip(path))


def test_a_folder_in_which_a_file_is_written_over_is_looked_at_anew(
    tmp_path: Path, model: DynamicGaussians
) -> None:
    path = tmp_path / "clip"
    write_phantom(path, PhantomParams(n_frames=3, width=32, height=24), "endonerf")
    there = next((path / "images").iterdir())
    before = there.read_bytes()
    image = np.full((24, 32, 3), 90, np.uint8)
    write_image(there, image, {})
    record = make_run(tmp_path / "run", phantom_path(), model).record()
    gone = str(tmp_path / "gone" / path.name)
    record = replace(record, clip=replace(record.clip, path=gone, frames=3, sha256=digest(path)))
    finder = RunFinder()
    there.write_bytes(before)
    assert not finder._is_of(record, open_clip(path))
    write_image(there, image, {})
    assert finder._is_of(record, open_clip(path))
