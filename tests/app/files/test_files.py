"""Files that appear whole or not at all, and sheets of pictures."""

from __future__ import annotations

import errno
import io
import os
import stat
import sys
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from PIL import Image, ImageOps

from app.enhancement.contact_sheet import (
    BACKGROUND,
    GAP,
    LABEL_PADDING,
    LINE_HEIGHT,
    TITLE_HEIGHT,
    Tile,
    sheet,
)
from app.errors import UserError
from app.files.atomic import filled, replaced, together, write_bytes
from app.files.image_files import read_image, write_image
from app.files.timing import Timing
from app.files.video import write_video
from renderer.atomic_files import written_atomically
from renderer.leftovers import temporary_name
from renderer.readers.image_files.pictures import read_rgb


def _write_half(path: Path) -> None:
    with replaced(path) as temporary:
        temporary.write_bytes(b"half")
        raise RuntimeError


def _fill_half(folder: Path) -> None:
    with filled(folder) as staging:
        (staging / "1").touch()
        raise RuntimeError


def _fill(folder: Path, *names: str) -> None:
    with filled(folder) as staging:
        for name in names:
            (staging / name).touch()


def test_a_file_is_replaced_only_when_all_went_well(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "file.txt"
    write_bytes(path, b"old")
    with pytest.raises(RuntimeError):
        _write_half(path)
    assert path.read_bytes() == b"old"
    assert list(path.parent.iterdir()) == [path]
    write_bytes(path, b"new")
    assert path.read_bytes() == b"new"


def test_a_folder_is_filled_only_when_all_went_well(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    with pytest.raises(RuntimeError):
        _fill_half(folder)
    assert list(tmp_path.iterdir()) == []
    with filled(folder) as staging:
        (staging / "1").write_text("new")
        assert not folder.exists()
    assert [path.name for path in folder.iterdir()] == ["1"]
    (folder / "kept").touch()
    with filled(folder) as staging:
        (staging / "1").write_text("newer")
    assert sorted(path.name for path in folder.iterdir()) == ["1", "kept"]
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="needs a second file system")
def test_a_folder_on_another_file_system_is_filled(tmp_path: Path) -> None:
    with tempfile.TemporaryDirectory(dir="/dev/shm") as other:
        link = tmp_path / "link"
        link.symlink_to(other)
        with filled(link) as staging:
            (staging / "1").touch()
        assert [path.name for path in link.iterdir()] == ["1"]


def test_a_folder_that_exists_needs_nothing_of_its_parent(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    with filled(folder) as staging:
        assert staging.parent == folder
        (staging / "1").touch()
    assert [path.name for path in folder.iterdir()] == ["1"]
    # The root has no parent; who may not write there is told so in a line.
    with suppress(UserError), filled(Path(tmp_path.anchor)) as staging:
        assert staging.parent == Path(tmp_path.anchor)


def test_a_folder_in_the_place_of_a_file_stops_all(tmp_path: Path) -> None:
    (tmp_path / "out" / "2").mkdir(parents=True)
    with pytest.raises(UserError, match=r"out.2$"):
        _fill(tmp_path / "out", "1", "2")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["2"]


def test_errors_name_the_file_that_was_wanted(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such") as caught, replaced(tmp_path / "file.txt") as temporary:
        temporary.read_bytes()
    assert caught.value.filename == str(tmp_path / "file.txt")
    with pytest.raises(OSError, match="No such") as caught, filled(tmp_path / "folder") as staging:
        (staging / "1").read_bytes()
    assert caught.value.filename == str(tmp_path / "folder" / "1")
    assert list(tmp_path.iterdir()) == []


def test_the_file_is_synced_through_a_handle_that_may_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows refuses to sync any other, and syncs no folders."""

    def sync(handle: int) -> None:
        if not stat.S_ISDIR(os.fstat(handle).st_mode):
            os.write(handle, b"")

    monkeypatch.setattr("app.files.atomic.os.fsync", sync)
    write_bytes(tmp_path / "file.txt", b"content")
    assert (tmp_path / "file.txt").read_bytes() == b"content"


@pytest.mark.parametrize(
    ("suffix", "dtype", "shape"),
    [
        (".png", np.uint8, (5, 6, 4)),
        (".png", np.uint16, (5, 6, 3)),
        (".png", np.uint8, (5, 6)),
        (".tiff", np.float32, (5, 6, 3)),
        (".tiff", np.uint16, (5, 6)),
        (".npy", np.float64, (5, 6, 3)),
        (".bmp", np.uint8, (5, 6, 3)),
    ],
)
def test_pictures_keep_type_channels_and_values(
    tmp_path: Path, suffix: str, dtype: type, shape: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(0)
    image = (rng.random(shape) * (np.iinfo(dtype).max if np.issubdtype(dtype, np.integer) else 1)).astype(
        dtype
    )
    path = tmp_path / f"picture{suffix}"
    write_image(path, image, {})
    read = read_image(path)
    assert read.dtype == dtype
    assert np.array_equal(read, image)


def test_a_video_of_mixed_sizes_is_refused_and_not_written(tmp_path: Path) -> None:
    frames = [np.zeros((16, 32, 3), dtype=np.uint8), np.zeros((16, 16, 3), dtype=np.uint8)]
    with pytest.raises(UserError, match="32x16"):
        write_video(tmp_path / "out.mp4", iter(frames), Timing(25.0))
    assert list(tmp_path.iterdir()) == []


def test_a_sheet_shows_every_tile_where_its_label_is() -> None:
    colors = [(255, 0, 0), (0, 255, 0), (0, 0, 255)]
    tiles = [Tile(f"{color[0]}\ntile", np.full((20, 40, 3), color, dtype=np.uint8)) for color in colors]
    picture = sheet("Title", tiles, "Foot", columns=2, tile_width=80)
    above = 2 * LINE_HEIGHT + LABEL_PADDING
    cell = 40 + above
    for index, color in enumerate(colors):
        x = GAP + index % 2 * (80 + GAP)
        y = TITLE_HEIGHT + index // 2 * (cell + GAP) + above
        assert (picture[y : y + 40, x : x + 80] == color).all()
        label = picture[y - above : y, x : x + 80]
        assert (label != BACKGROUND).any()
    # The empty place of the last row stays neutral.
    assert (picture[TITLE_HEIGHT + cell + GAP :, 80 + 2 * GAP :][:cell] == BACKGROUND).all()


def test_a_long_label_is_broken_and_keeps_its_size_within_its_tile() -> None:
    """Words of capitals, each as high as the others in whatever line."""
    images = np.zeros((20, 40, 3), dtype=np.uint8)
    picture = sheet("T", [Tile("HIH " * 15, images), Tile("HIH", images)], "F", columns=2, tile_width=150)
    width, left = GAP + 150, picture[TITLE_HEIGHT:, GAP:][:, :150]
    assert (picture[TITLE_HEIGHT:-30, width : width + GAP] == BACKGROUND).all()
    dark = (left == 0).all(axis=(1, 2))
    lines = (left[: int(np.argmax(dark))] > 200).any(axis=(1, 2))
    starts, ends = (np.flatnonzero(np.diff(lines.astype(int)) == step) for step in (1, -1))
    alone = (picture[TITLE_HEIGHT:, 2 * width - 150 : 2 * width] > 200).any(axis=(1, 2))
    assert len(starts) > 2
    assert set(ends - starts) == {int(alone[: int(np.argmax(dark))].sum())}


@pytest.mark.parametrize("suffix", ["png", "webp", "tiff"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_other_pictures_are_read_as_they_are_looked_at(tmp_path: Path, orientation: int, suffix: str) -> None:
    """As `train` reads them, too."""
    stored = Image.fromarray(np.random.default_rng(3).integers(0, 255, (24, 40, 3), np.uint8))
    exif = Image.Exif()
    exif[0x0112] = orientation
    path = tmp_path / f"turned.{suffix}"
    stored.save(path, exif=exif, **({"lossless": True} if suffix == "webp" else {}))
    read = read_image(path)
    assert read.shape[:2] == ((24, 40) if orientation < 5 else (40, 24))
    with Image.open(path) as opened:
        np.testing.assert_array_equal(read, np.asarray(ImageOps.exif_transpose(opened)))
    np.testing.assert_array_equal(read, read_rgb(path))


@pytest.mark.parametrize("grey", [False, True])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_jpeg_is_read_as_it_is_looked_at(tmp_path: Path, orientation: int, grey: bool) -> None:
    """By its EXIF orientation, whatever the file is called; so a mask of the looked-at size fits it."""
    y, x = np.mgrid[:24, :40]
    picture = np.stack([6 * x, 10 * y, 3 * (x + y)], axis=2).astype(np.uint8)
    stored = Image.fromarray(picture[..., 0] + picture[..., 1] // 2 if grey else picture)
    exif = Image.Exif()
    exif[0x0112] = orientation
    for path in (tmp_path / "picture.jpg", tmp_path / "picture.png"):
        stored.save(path, "JPEG", exif=exif, quality=95)
        with Image.open(path) as opened:
            upright = np.asarray(ImageOps.exif_transpose(opened)).astype(int)
        read = read_image(path)
        assert read.shape == upright.shape
        assert read.shape[:2] == ((24, 40) if orientation < 5 else (40, 24))
        assert np.abs(read - upright).mean() < 1


def test_what_is_no_jpeg_keeps_its_alpha_whatever_its_name(tmp_path: Path) -> None:
    picture = np.random.default_rng(0).integers(0, 255, (8, 9, 4), np.uint8)
    (tmp_path / "picture.jpg").write_bytes(cv2.imencode(".png", picture)[1].tobytes())
    assert np.array_equal(read_image(tmp_path / "picture.jpg")[..., 3], picture[..., 3])


def test_a_link_under_the_temporary_name_is_not_followed(tmp_path: Path) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "run"
    folder.mkdir()
    outside.write_bytes(b"precious")
    (folder / temporary_name("run", ".json")).symlink_to(outside)
    write_bytes(folder / "run.json", b"new")
    assert outside.read_bytes() == b"precious"
    assert [path.name for path in folder.iterdir()] == ["run.json"]
    assert not (folder / "run.json").is_symlink()


@pytest.mark.parametrize("kind", [OSError, av.error.OSError])
def test_a_full_disk_is_told_of_the_file_that_was_asked_for(tmp_path: Path, kind: type[OSError]) -> None:
    """FFmpeg names it as an address, in the temporary folder of all that appears at once."""
    path = tmp_path / "film.mp4"
    with (
        pytest.raises(OSError, match="No space left") as told,
        together(path) as place,
        replaced(place) as new,
    ):
        raise kind(errno.ENOSPC, "No space left on device", f"file:{new}")
    assert told.value.filename == str(path)


@pytest.mark.parametrize("write", [replaced, written_atomically])
def test_a_read_only_disk_is_told_of_the_file_that_was_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path], AbstractContextManager[Path]]
) -> None:
    """Where not even what is not there can be removed."""

    def refused(path: Path, missing_ok: bool = False) -> None:
        raise OSError(errno.EROFS, "Read-only file system", str(path))

    monkeypatch.setattr(Path, "unlink", refused)
    with pytest.raises(OSError, match="Read-only") as told, write(tmp_path / "a.png"):
        pass
    assert told.value.filename == str(tmp_path / "a.png")


def test_a_link_at_the_target_is_followed(tmp_path: Path) -> None:
    """As of settings that lie in a folder of such files."""
    kept, folder = tmp_path / "kept", tmp_path / "config"
    for made in (kept, folder):
        made.mkdir()
    (kept / "mine.json").write_bytes(b"old")
    (folder / "settings.json").symlink_to(Path("..") / "kept" / "mine.json")
    write_bytes(folder / "settings.json", b"new")
    assert (folder / "settings.json").is_symlink()
    assert (kept / "mine.json").read_bytes() == b"new"
    assert [path.name for path in kept.iterdir()] == ["mine.json"]
    assert [path.name for path in folder.iterdir()] == ["settings.json"]


def test_a_link_that_leads_back_to_itself_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to(tmp_path / "a")
    write_bytes(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_bytes() == b"new"


@pytest.mark.parametrize("length", [100, 235])
def test_windows_says_that_a_path_is_too_long_while_it_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, length: int
) -> None:
    folder = tmp_path
    while len(str(folder)) < length - 13:
        folder /= "x" * min(40, length - 14 - len(str(folder)))
    folder.mkdir(parents=True, exist_ok=True)

    def as_on_windows(call: Callable[..., Any], most: int) -> Callable[..., Any]:
        def called(path: Any, *rest: Any, **named: Any) -> Any:
            if isinstance(path, str | os.PathLike) and len(os.fspath(path)) > most:
                raise FileNotFoundError(errno.ENOENT, "No such file or directory", os.fspath(path))
            return call(path, *rest, **named)

        return called

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(io, "open", as_on_windows(io.open, 259))
    monkeypatch.setattr(os, "mkdir", as_on_windows(os.mkdir, 247))
    file = folder / "film.json"
    if length < 200:
        write_bytes(file, b"{}")
        return
    with pytest.raises(OSError, match="too long") as caught:
        write_bytes(file, b"{}")
    assert caught.value.strerror == "the path is too long for Windows, take a shorter one"
    with pytest.raises(UserError, match="too long for Windows"), together(file):
        pass
    assert list(folder.iterdir()) == []
