"""What opens alone counts in a folder as well, in the window and the commands; the rest is named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from app.commands.described.paths import described
from app.enhancement.batch import enhance_batch, items_in
from app.enhancement.enhance_files import Setting
from app.errors import UserError
from app.files.image_series import open_series
from app.files.provenance import digest
from enhance import EnhanceParams
from renderer.clip import ByteImage, ClipError
from renderer.readers.image_files import file_kinds
from renderer.readers.image_files.coded_picture import CodedPicture
from renderer.readers.image_files.pictures import read_rgb, upright_size
from renderer.readers.image_folders import passed_over
from renderer.readers.image_folders.stills import images_in, open_stills
from renderer.sources import open_case, open_clip
from tests.app.conftest import Cli
from tests.renderer.readers.numbered import encoded
from tests.renderer.readers.tiled_avif import tiled

SIZE = 64, 48
SETTING = Setting("paper", EnhanceParams(d_factor=0.5))
NAMES = "a.png", "b.avif", "c.jp2", "d"


def _image(shade: int, size: tuple[int, int] = SIZE) -> Image.Image:
    across = np.linspace(40, 200, size[0]).astype(np.uint8)
    return Image.fromarray(
        np.stack([np.tile(across, (size[1], 1)), *2 * [np.full(size[::-1], shade, np.uint8)]], 2)
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    found = tmp_path / "case"
    found.mkdir()
    for shade, (name, kind) in enumerate(zip(NAMES, ("PNG", "AVIF", "JPEG2000", "JPEG"), strict=True)):
        _image(60 + 20 * shade).save(found / name, kind)
    return found


def test_a_folder_whose_files_may_not_be_looked_at_is_named(
    folder: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing that is looked for in it, such as frame_data of SCARED."""
    monkeypatch.setattr("renderer.regular_files.os.access", lambda path, how: path != folder)
    for call in (("enhance", folder, tmp_path / "out"), ("metrics", folder)):
        refused = vesselsplat(*call)
        assert (refused.code, refused.out) == (2, "")
        assert refused.error == f"vesselsplat: Permission denied: {folder}\n"
    assert not (tmp_path / "out").exists()


def test_each_is_an_image_of_the_folder_as_it_is_alone(folder: Path) -> None:
    (folder / "notes.txt").write_text("seen")
    clip = open_clip(folder)
    assert clip.labels == NAMES
    assert clip.notices == ("left out, not numbered images: notes.txt",)
    assert [path.name for path in images_in(folder)] == list(NAMES)
    for index, name in enumerate(NAMES):
        alone = open_clip(folder / name)
        assert (alone.format, len(alone)) == ("image", 1)
        assert np.array_equal(clip.read_image(index), alone.read_image(0))
        assert {fact.name: fact.text for fact in described(folder / name)}["what"] == "clip: one image"
    series = open_series(folder)
    assert series.names == ("a", "b", "c", "d")
    assert all(np.array_equal(series.read(index), clip.read_image(index)) for index in range(4))
    assert series.notices == ("left out, not images: notes.txt",)
    known = digest(folder)
    _image(200).save(folder / "b.avif")
    assert digest(folder) != known


def test_with_images_of_another_size_the_rest_is_named_too(folder: Path) -> None:
    _image(90, (32, 24)).save(folder / "e.png")
    (folder / "f.png").write_bytes(b"broken")
    (folder / "notes.txt").write_text("seen")
    clip = open_case(folder)
    assert clip.labels == (*NAMES, "e.png")
    assert clip.notices == ("left out, not readable: f.png", "left out, not images: notes.txt")
    (folder / "f.png").unlink()
    told = {fact.name: fact.value for fact in described(folder)}
    assert told["notices"] == ["left out, not images: notes.txt"]


def test_a_video_beside_the_images_is_named_where_it_is_not_enhanced_too(
    folder: Path, tmp_path: Path
) -> None:
    encoded(folder / "scope.mp4", 3 * [np.asarray(_image(90))])
    said = "left out, not images: scope.mp4"
    assert open_series(folder).notices == (said,)

    def notices(output: str, *, below: bool) -> list[str]:
        steps = enhance_batch(items_in((folder,), tmp_path / output, below=below), SETTING)
        return [one for step in steps if step.written is not None for one in step.written.notices]

    assert said in notices("alone", below=False)
    assert said not in notices("all", below=True)


def test_a_link_to_nothing_is_named(folder: Path, tmp_path: Path) -> None:
    said = "left out, broken links: lost.png"
    (folder / "lost.png").symlink_to(tmp_path / "nowhere.png")
    assert said in open_series(folder).notices
    assert said in open_stills(folder).notices
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty/lost.png").symlink_to("lost.png")
    with pytest.raises(UserError, match=rf"found none in .*; {said}$"):
        open_series(tmp_path / "empty")


def test_a_record_is_no_stray_beside_the_file_that_it_tells_of(folder: Path) -> None:
    for name in ("a.png.json", "scope.mp4", "scope.mp4.json", "gone.mp4.json", "a.json"):
        (folder / name).write_text("{}")
    assert open_series(folder).notices == ("left out, not images: a.json, gone.mp4.json, scope.mp4",)


def test_without_pyav_they_are_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nowhere: Callable[[], bool] = lambda: False  # noqa: E731
    monkeypatch.setattr(file_kinds, "has_pyav", nowhere)
    monkeypatch.setattr(passed_over, "has_pyav", nowhere)
    said = "left out, not readable without PyAV: b.avif, c.jp2"
    assert open_clip(folder).labels == ("a.png", "d")
    assert said in open_clip(folder).notices
    assert said in open_series(folder).notices


@pytest.mark.parametrize("turn", [1, 3, 6, 8])
def test_one_that_lies_on_its_side_is_as_large_as_it_is_read(
    tmp_path: Path, turn: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    exif = Image.Exif()
    exif[0x0112] = turn
    _image(90).save(tmp_path / "a.avif", exif=exif)
    stored: ByteImage = read_rgb(tmp_path / "a.avif")
    assert stored.shape[1::-1] == (SIZE if turn in (1, 3) else SIZE[::-1])
    # Pixels are none of the header's business.
    monkeypatch.setattr(CodedPicture, "load", None)
    assert upright_size(tmp_path / "a.avif") == stored.shape[1::-1]


def test_a_misnamed_one_is_what_it_is(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6
    _image(90).save(tmp_path / "a.heic", "JPEG", exif=exif)
    assert open_clip(tmp_path).size == SIZE[::-1]
    assert np.array_equal(open_series(tmp_path).read(0), open_clip(tmp_path).read_image(0))


def _cut(path: Path) -> None:
    path.write_bytes(b"\0\0\0\x18ftypheic" + bytes(100))


def test_one_that_does_not_open_is_named_beside_others(folder: Path, tmp_path: Path) -> None:
    known = digest(folder)
    _cut(folder / "e.heic")
    tiled(folder / "f.avif", _image(90))
    said = "left out, not readable: e.heic, f.avif"
    assert open_clip(folder).labels == NAMES
    assert open_clip(folder).notices == (said,)
    assert open_series(folder).names == ("a", "b", "c", "d")
    assert open_series(folder).notices == (said,)
    assert digest(folder) == known
    (tmp_path / "alone").mkdir()
    _cut(tmp_path / "alone/e.heic")
    with pytest.raises(ClipError, match="got a HEIC image: convert it"):
        open_clip(tmp_path / "alone")


def test_of_one_name_the_plainer_suffix_counts(folder: Path) -> None:
    known = digest(folder)
    _image(90).save(folder / "a.avif")
    _image(90).save(folder / "a", "JPEG")
    said = "left out, beside an image of the same name: a, a.avif"
    assert open_clip(folder).labels == NAMES
    assert open_clip(folder).notices == (said,)
    assert open_series(folder).names == ("a", "b", "c", "d")
    assert open_series(folder).notices == (said,)
    assert digest(folder) == known
    _image(90).save(folder / "b.jp2")
    with pytest.raises(ClipError, match=r"one image per name, got b\.avif and b\.jp2"):
        open_clip(folder)


@pytest.mark.parametrize(("kind", "counts"), [("MPO", True), ("TIFF", True), ("PNG", False), ("WEBP", False)])
def test_without_a_suffix_pages_are_images_and_films_are_not(tmp_path: Path, kind: str, counts: bool) -> None:
    _image(60).save(tmp_path / "a.png")
    _image(90).save(tmp_path / "b", kind, save_all=True, append_images=[_image(120)])
    clip = open_clip(tmp_path)
    assert clip.labels == (("a.png", "b") if counts else ("a.png",))
    paged = "of a file with several images only the first is read: b of 2"
    assert (paged in clip.notices) == (kind == "TIFF")
