"""`vesselsplat masks`: what a hand has drawn in its folder stays when it runs again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from app.__main__ import main
from renderer.readers.masks.nonzero_masks import read_nonzero
from renderer.tools.mask_files import origin_of, write_mask

SIZE = (48, 32)


@pytest.fixture
def frames(tmp_path: Path) -> Path:
    folder, rng = tmp_path / "frames", np.random.default_rng(0)
    folder.mkdir()
    for index in range(3):
        image = rng.integers(90, 130, (SIZE[1], SIZE[0], 3), dtype=np.uint8) + np.uint8([90, 20, 10])
        Image.fromarray(image).save(folder / f"f_{index}.png")
    return folder


def test_a_mask_that_was_mended_by_hand_stays_and_is_named(
    frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, drawn = tmp_path / "out", np.zeros((SIZE[1], SIZE[0]), bool)
    drawn[:5] = True
    assert main(["masks", str(frames), "--out", str(out)]) == 0
    assert "kept" not in capsys.readouterr().out
    mended = sorted(out.glob("*.png"))[1]
    Image.fromarray(drawn).save(mended)
    assert main(["masks", str(frames), "--out", str(out)]) == 0
    np.testing.assert_array_equal(read_nonzero(mended, SIZE), drawn)
    assert f"kept as drawn by hand in {out}: {mended.name}" in capsys.readouterr().out
    assert [origin_of(path) for path in sorted(out.glob("*.png"))].count("by hand") == 1


def test_a_mask_that_is_given_counts_before_one_in_the_folder(frames: Path, tmp_path: Path) -> None:
    out, given = tmp_path / "out", tmp_path / "given"
    given.mkdir()
    assert main(["masks", str(frames), "--out", str(out)]) == 0
    path, drawn = sorted(out.glob("*.png"))[0], np.zeros((SIZE[1], SIZE[0]), bool)
    write_mask(path, drawn, "by hand")
    write_mask(given / path.name, ~drawn, "by hand")
    assert main(["masks", str(frames), "--out", str(out), "--given", str(given)]) == 0
    assert read_nonzero(path, SIZE).all()


def test_one_mask_is_told_as_one(frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["masks", str(frames / "f_0.png"), "--out", str(tmp_path / "out")]) == 0
    assert ": 1 mask, tools in " in capsys.readouterr().out
