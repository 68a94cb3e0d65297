"""Videos written: size, rate and colours as given, tagged so that players agree."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.color_tag import tag_colors
from app.errors import UserError
from app.video import write_video

RED = (200, 60, 50)


def frames(count: int, height: int = 48, width: int = 64) -> list[np.ndarray]:
    """RGB, red, with a bright square that moves by 4 pixels a frame."""
    pictures = []
    for index in range(count):
        picture = np.full((height, width, 3), RED, np.uint8)
        picture[8:16, 4 * index : 4 * index + 8] = 250
        pictures.append(picture)
    return pictures


def read(path: Path) -> tuple[list[np.ndarray], float]:
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    pictures = []
    while True:
        ok, picture = capture.read()
        if not ok:
            return pictures, capture.get(cv2.CAP_PROP_FPS)
        pictures.append(picture[..., ::-1])


@pytest.mark.parametrize("rate", [10.0, 25.0, 29.97, 59.94])
def test_frames_rate_and_colours_come_back(tmp_path: Path, rate: float) -> None:
    path = tmp_path / "out.mp4"
    given = frames(7)
    assert write_video(path, iter(given), rate).notices == ()
    pictures, read_rate = read(path)
    assert read_rate == pytest.approx(rate, rel=1e-4)
    assert len(pictures) == 7
    for before, after in zip(given, pictures, strict=True):
        assert np.abs(after.astype(int) - before).mean() < 6
        assert np.abs(after[40, 50].astype(int) - RED).max() <= 6


def test_grey_and_alpha_are_written_as_colours(tmp_path: Path) -> None:
    grey = [np.full((16, 32), level, np.uint8) for level in (50, 200)]
    write_video(tmp_path / "grey.mp4", iter(grey), 5.0)
    assert np.abs(read(tmp_path / "grey.mp4")[0][1].astype(int) - 200).max() <= 4
    alpha = [np.dstack((picture, np.full((48, 64), 7, np.uint8))) for picture in frames(2)]
    write_video(tmp_path / "alpha.mp4", iter(alpha), 5.0)
    assert np.abs(read(tmp_path / "alpha.mp4")[0][0][40, 50].astype(int) - RED).max() <= 6


def test_odd_sizes_lose_their_last_pixels_and_say_so(tmp_path: Path) -> None:
    written = write_video(tmp_path / "odd.mp4", iter(frames(2, 47, 63)), 5.0)
    assert written.notices == ("the codec holds even sizes: 63x47 was cut to 62x46",)
    assert read(tmp_path / "odd.mp4")[0][0].shape == (46, 62, 3)


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        (np.zeros((8, 8, 3), np.uint16), "8-bit"),
        (np.zeros((8, 8), np.float32), "8-bit"),
        (np.zeros((1, 8, 3), np.uint8), "2x2 pixels or more, got 8x1"),
        (np.zeros((1, 1, 3), np.uint8), "2x2 pixels or more, got 1x1"),
    ],
)
def test_what_no_video_holds_is_refused_and_nothing_written(
    tmp_path: Path, frame: np.ndarray, says: str
) -> None:
    with pytest.raises(UserError, match=says):
        write_video(tmp_path / "out.mp4", iter([frame]), 25.0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(find_spec("av") is not None, reason="tags are those of the input with PyAV")
def test_the_tag_says_what_opencv_wrote(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    assert "BT.601" in write_video(path, iter(frames(3)), 25.0).encoding
    content = path.read_bytes()
    at = content.index(b"colrnclx")
    assert content[at + 8 : at + 15] == bytes([0, 1, 0, 1, 0, 6, 0])
    assert content.index(b"moov") < content.index(b"stsd") < at < content.index(b"stts")


@pytest.mark.skipif(find_spec("av") is not None, reason="the tag is OpenCV's reader's guide here")
def test_a_reader_follows_the_tag(tmp_path: Path) -> None:
    """The same bytes tagged BT.709 decode to other reds: the tag is not decoration."""
    path = tmp_path / "out.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 25.0, (64, 48))
    for picture in frames(3):
        writer.write(picture[..., ::-1])
    writer.release()
    plain = read(path)[0][0]
    tag_colors(path, 1, 1, 1)
    assert np.abs(read(path)[0][0].astype(int) - plain).max() > 8


def test_other_files_are_not_tagged(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    for content in (b"", b"no video at all", b"\0\0\0\x08moov"):
        path.write_bytes(content)
        with pytest.raises(ValueError, match="expected"):
            tag_colors(path, 1, 1, 6)
        assert path.read_bytes() == content


@pytest.mark.skipif(find_spec("av") is None, reason="needs PyAV")
@pytest.mark.parametrize("tags", [(1, 1, 1), (6, 6, 6), (2, 2, 2)])
def test_tags_of_the_input_are_kept_and_colours_do_not_move(
    tmp_path: Path, tags: tuple[int, int, int]
) -> None:
    import av

    given = tmp_path / "in.mp4"
    with av.open(str(given), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        codec = stream.codec_context
        codec.color_primaries, codec.color_trc, codec.colorspace = tags
        for picture in frames(3):
            frame = av.VideoFrame.from_ndarray(picture, "rgb24").reformat(format="yuv420p")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    decoded = read(given)[0]
    write_video(tmp_path / "out.mp4", iter(decoded), 25.0, like=given)
    with av.open(str(tmp_path / "out.mp4")) as container:
        codec = container.streams.video[0].codec_context
        assert (codec.color_primaries, codec.color_trc, codec.colorspace) == tags
    again = read(tmp_path / "out.mp4")[0]
    assert np.abs(again[1][40, 50].astype(int) - decoded[1][40, 50]).max() <= 3
