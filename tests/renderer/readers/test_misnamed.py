"""Files under wrong names: the refusal says what they are."""

from __future__ import annotations

import builtins
import gzip
import io
import re
import zipfile
from pathlib import Path
from types import ModuleType

import av
import cv2
import numpy as np
import pytest
from PIL import Image

from app.errors import UserError
from app.files.image_files import read_image
from renderer.clip import ClipError
from renderer.readers.misnamed import VIDEO, neither, what_it_is
from renderer.readers.video_header import read_counted_header
from renderer.sources import open_clip
from tests.renderer.readers.numbered import encoded, opencv_video

VIDEOS = ("a.mp4", "a.mkv", "a.mov", "a.mpg", "a.avi")
PICTURE = [np.zeros((16, 16, 3), np.uint8)]


def contents(folder: Path) -> dict[str, bytes]:
    """Real files of each kind, and what a word of the refusal is."""
    for name in VIDEOS[:-1]:
        encoded(folder / name, PICTURE, "mpeg2video" if name == "a.mpg" else "libx264")
    opencv_video(folder / "a.avi", "MJPG", 1)
    with zipfile.ZipFile(folder / "a.zip", "w") as archive:
        archive.writestr("1.png", b"")
    return {
        **{VIDEO + name: (folder / name).read_bytes() for name in VIDEOS},
        "a zip archive": (folder / "a.zip").read_bytes(),
        "a gzip file": gzip.compress(b"picture", mtime=0),
        "a HEIC image": b"\0\0\0\x18ftypheic" + bytes(100),
        "a JPEG XL image": b"\0\0\0\x0cJXL \r\n\x87\n" + bytes(100),
        "a PDF document": b"%PDF-1.7" + bytes(100),
        "an empty file": b"",
    }


def test_a_refusal_names_what_came_under_the_name_of_a_picture(tmp_path: Path) -> None:
    for kind, content in contents(tmp_path).items():
        path = tmp_path / "frame.png"
        path.write_bytes(content)
        said = VIDEO if kind.startswith(VIDEO) else kind
        for reads, error in ((open_clip, ClipError), (read_image, UserError)):
            with pytest.raises(error, match=f"expected an image, got {said}"):
                reads(path)


def test_a_file_that_may_not_be_read_is_not_called_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = [tmp_path / name for name in ("frame.png", "frame.tif")]
    for path in paths:
        Image.fromarray(PICTURE[0]).save(path)

    def bar(module: ModuleType) -> None:
        """The system lets a superuser read all."""
        free = module.open

        def barred(given: object, *rest: object, **more: object) -> object:
            if str(given).startswith(str(tmp_path)):
                raise PermissionError(13, "Permission denied", str(given))
            return free(given, *rest, **more)

        monkeypatch.setattr(module, "open", barred)

    bar(builtins)
    bar(io)
    said = r"got a file that may not be read \(Permission denied\)"
    for path in paths:
        with pytest.raises(ClipError, match=f"expected an image, {said}"):
            open_clip(path)
        with pytest.raises(PermissionError, match="Permission denied"):
            read_image(path)
        assert re.match(f"expected an image or a video, {said}", neither(path))


@pytest.mark.parametrize("kind", ["a zip archive", "a JPEG XL image", "a PDF document", "an empty file"])
def test_and_of_a_video(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "case.mp4"
    path.write_bytes(contents(tmp_path)[kind])
    with pytest.raises(ClipError, match=f"expected an image or a video, got {kind}"):
        open_clip(path)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp"])
def test_an_image_under_the_name_of_a_video_is_no_video(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / "case.mp4"
    path.write_bytes(cv2.imencode(suffix, np.zeros((16, 16, 3), np.uint8))[1].tobytes())
    for reads in (open_clip, read_counted_header):
        with pytest.raises(ClipError, match="expected a video, got an image: rename it"):
            reads(path)


def test_what_nothing_tells_is_left_open(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"anything else")
    assert what_it_is(tmp_path / "a") is None
    assert what_it_is(tmp_path / "not there") is None


def test_an_image_of_light_is_no_video_of_grey_levels(tmp_path: Path) -> None:
    for name, codec, layout in (("a.exr", "exr", "gbrpf32le"), ("a.hdr", "hdr", "gbrpf32le")):
        with av.open(str(tmp_path / name), "w", format="image2", options={"update": "1"}) as file:
            stream = file.add_stream(codec, rate=1)
            stream.width, stream.height, stream.pix_fmt = 32, 24, layout
            light = av.VideoFrame.from_ndarray(np.full((24, 32, 3), 90, np.uint8), "rgb24")
            file.mux(stream.encode(light.reformat(format=layout)))
            file.mux(stream.encode())
        for read in (open_clip, read_counted_header):
            with pytest.raises(ClipError, match=r"got an? (OpenEXR|Radiance HDR) image: convert it"):
                read(tmp_path / name)
