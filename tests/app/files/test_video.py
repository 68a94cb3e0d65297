"""Videos written: size, rate and colours as given, tagged so that players agree."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import IO, Any

import av
import cv2
import numpy as np
import pytest

from app.errors import UserError
from app.files.image_series import open_series
from app.files.mpeg4_video import Mpeg4Writer, tag_colors
from app.files.timing import Timing
from app.files.video import write_video
from app.files.video_encoder import VideoEncoder, video_encoder
from renderer.sources import open_clip
from tests.app.conftest import Cli
from tests.renderer.readers.numbered import INTERLACED, encoded, turned, woven

RED = (200, 60, 50)


def without(monkeypatch: pytest.MonkeyPatch, *programs: str) -> None:
    """As on a machine that has none of them."""
    if "PyAV" in programs:
        monkeypatch.setattr("app.files.video_encoder.has_pyav", lambda: False)
    if "ffmpeg" in programs:
        monkeypatch.setattr("app.files.video_encoder.which", lambda name: None)


@pytest.fixture(params=["PyAV", "ffmpeg", "OpenCV"])
def encoder(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param != "PyAV":
        without(monkeypatch, "PyAV")
    if request.param == "OpenCV":
        without(monkeypatch, "ffmpeg")
    if video_encoder().program != request.param:
        pytest.skip(f"{request.param} is not on this machine")
    return str(request.param)


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
def test_frames_rate_and_colours_come_back(tmp_path: Path, encoder: str, rate: float) -> None:
    path = tmp_path / "out.mp4"
    given = frames(7)
    assert write_video(path, iter(given), Timing(rate)).notices == ()
    pictures, read_rate = read(path)
    assert read_rate == pytest.approx(rate, rel=1e-4)
    assert len(pictures) == 7
    for before, after in zip(given, pictures, strict=True):
        assert np.abs(after.astype(int) - before).mean() < 6
        assert np.abs(after[40, 50].astype(int) - RED).max() <= 6


def test_grey_and_alpha_are_written_as_colours(tmp_path: Path, encoder: str) -> None:
    grey = [np.full((16, 32), level, np.uint8) for level in (50, 200)]
    write_video(tmp_path / "grey.mp4", iter(grey), Timing(5.0))
    assert np.abs(read(tmp_path / "grey.mp4")[0][1].astype(int) - 200).max() <= 4
    alpha = [np.dstack((picture, np.full((48, 64), 7, np.uint8))) for picture in frames(2)]
    write_video(tmp_path / "alpha.mp4", iter(alpha), Timing(5.0))
    assert np.abs(read(tmp_path / "alpha.mp4")[0][0][40, 50].astype(int) - RED).max() <= 6


def test_odd_sizes_lose_their_last_pixels_and_say_so(tmp_path: Path, encoder: str) -> None:
    written = write_video(tmp_path / "odd.mp4", iter(frames(2, 47, 63)), Timing(5.0))
    assert written.notices == ("the codec needs even sizes: 63x47 was cut to 62x46",)
    assert read(tmp_path / "odd.mp4")[0][0].shape == (46, 62, 3)


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        (np.zeros((8, 8, 3), np.uint16), "8-bit"),
        (np.zeros((8, 8), np.float32), "8-bit"),
        (np.zeros((1, 8, 3), np.uint8), "at least 2x2 pixels, got 8x1"),
        (np.zeros((1, 1, 3), np.uint8), "at least 2x2 pixels, got 1x1"),
    ],
)
def test_what_no_video_holds_is_refused_and_nothing_written(
    tmp_path: Path, encoder: str, frame: np.ndarray, says: str
) -> None:
    with pytest.raises(UserError, match=says):
        write_video(tmp_path / "out.mp4", iter([frame]), Timing(25.0))
    assert list(tmp_path.iterdir()) == []


def test_the_encoder_is_told_before_anything_is_written(tmp_path: Path, encoder: str) -> None:
    told = video_encoder()
    written = write_video(tmp_path / "out.mp4", iter(frames(3)), Timing(25.0))
    assert written.encoding.startswith(told.said.split(",")[0])
    with av.open(str(tmp_path / "out.mp4")) as container:
        assert container.streams.video[0].codec_context.name == ("mpeg4" if encoder == "OpenCV" else "h264")
    assert bool(told.way_out) == (encoder == "OpenCV")


def test_an_ffmpeg_without_h264_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "PyAV")
    program = tmp_path / "ffmpeg"
    for body, name in (
        ("echo ' V..... libopenh264 x'", "libopenh264"),
        ("echo ' V..... mpeg4 x'", "mp4v"),
        ("exit 1", "mp4v"),
    ):
        program.write_text(f"#!/bin/sh\n{body}\n")
        program.chmod(0o755)
        monkeypatch.setattr("app.files.video_encoder.which", lambda name: str(program))
        assert video_encoder().name == name
    monkeypatch.setattr("app.files.video_encoder._pyav_has", lambda name: False)
    monkeypatch.setattr("app.files.video_encoder.has_pyav", lambda: True)
    assert video_encoder() == VideoEncoder("OpenCV", "mp4v")


class WindowsPipe:
    """Says of a reader that has ended what Windows does."""

    def __init__(self, pipe: IO[Any]) -> None:
        self._pipe = pipe

    def write(self, content: bytes) -> None:
        self._say(self._pipe.write, content)

    def close(self) -> None:
        self._say(self._pipe.close)

    def _say(self, act: Callable[..., object], *given: bytes) -> None:
        try:
            act(*given)
        except BrokenPipeError:
            raise OSError(errno.EINVAL, "Invalid argument") from None


@pytest.mark.parametrize("on_windows", [False, True])
def test_an_ffmpeg_that_fails_is_one_line_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, on_windows: bool
) -> None:
    if on_windows:
        pipe = property(lambda self: WindowsPipe(self._process.stdin))
        monkeypatch.setattr("app.files.ffmpeg_video.FfmpegWriter._frames", pipe)
    program, out = tmp_path / "ffmpeg", tmp_path / "out" / "out.mp4"
    program.write_text(
        "#!/bin/sh\nexec <&-\nsleep 0.3\necho 'first' >&2\necho 'no space for x264' >&2\nexit 1\n"
    )
    program.chmod(0o755)
    monkeypatch.setattr("app.files.video.video_encoder", lambda: VideoEncoder("ffmpeg", "libx264"))
    monkeypatch.setattr("app.files.ffmpeg_video.which", lambda name: str(program))
    with pytest.raises(OSError, match="no space for x264"):
        write_video(out, iter(frames(40, 480, 640)), Timing(25.0))
    assert list(out.parent.iterdir()) == []


def test_the_tag_says_what_opencv_wrote(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "PyAV", "ffmpeg")
    path = tmp_path / "out.mp4"
    assert "BT.601" in write_video(path, iter(frames(3)), Timing(25.0)).encoding
    content = path.read_bytes()
    at = content.index(b"colrnclx")
    assert content[at + 8 : at + 15] == bytes([0, 1, 0, 1, 0, 6, 0])
    assert content.index(b"moov") < content.index(b"stsd") < at < content.index(b"stts")


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


def test_a_video_that_opencv_could_not_finish_is_named(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    writer = Mpeg4Writer(path, (64, 48), Timing(25.0))
    writer.write(frames(1)[0], None)
    writer.close()
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(OSError, match="is not whole") as caught:
        writer.finish()
    assert caught.value.filename == str(path)


@pytest.mark.parametrize(
    ("tags", "kept"),
    [((1, 1, 1), (1, 1, 1)), ((6, 6, 6), (6, 6, 6)), ((2, 2, 2), (2, 2, 2)), ((2, 1, 6), (1, 1, 6))],
)
def test_tags_of_the_input_are_kept_and_colours_do_not_move(
    tmp_path: Path, tags: tuple[int, int, int], kept: tuple[int, int, int]
) -> None:
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
    write_video(tmp_path / "out.mp4", iter(decoded), Timing(25.0, like=given))
    with av.open(str(tmp_path / "out.mp4")) as container:
        codec = container.streams.video[0].codec_context
        assert (codec.color_primaries, codec.color_trc, codec.colorspace) == kept
    again = read(tmp_path / "out.mp4")[0]
    assert np.abs(again[1][40, 50].astype(int) - decoded[1][40, 50]).max() <= 3


def test_a_video_plays_in_a_browser(tmp_path: Path) -> None:
    """H.264 of 8 bits and halved colours, with its index first."""
    path = tmp_path / "out.mp4"
    assert write_video(path, iter(frames(5)), Timing(25.0)).encoding.startswith("H.264")
    content = path.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")
    with av.open(str(path)) as container:
        codec = container.streams.video[0].codec_context
        assert (codec.name, codec.pix_fmt, codec.color_range) == ("h264", "yuv420p", 1)


@pytest.mark.parametrize("matrix", [1, 6])
def test_unchanged_frames_come_back_within_half_a_level(tmp_path: Path, matrix: int) -> None:
    """Read, written and read again, on average, in each colour."""
    rough = np.random.default_rng(4).uniform(30, 220, (3, 17, 17, 3)).astype(np.float32)
    pictures = [np.clip(cv2.resize(one, (256, 192)), 0, 255).astype(np.uint8) for one in rough]
    series = open_series(encoded(tmp_path / "in.mp4", pictures, options={"crf": "8"}, matrix=matrix))
    given = [series.read(index) for index in range(3)]
    write_video(tmp_path / "out.mp4", iter(given), series.timing)
    again = open_series(tmp_path / "out.mp4")
    for index in range(3):
        apart = again.read(index).astype(int) - given[index]
        assert np.abs(apart.mean(axis=(0, 1))).max() < 0.5


SOUNDS = {"in.mp4": "aac", "in.mkv": "libopus", "in.avi": "libmp3lame", "in.mov": "pcm_s16le"}


@pytest.mark.parametrize("name", SOUNDS)
def test_sound_is_kept(tmp_path: Path, name: str) -> None:
    """A beep in, the same beep out, as long as the pictures; that it was encoded again is said."""
    given = encoded(tmp_path / name, frames(15), sound=SOUNDS[name])
    series = open_series(given)
    written = write_video(tmp_path / "out.mp4", (series.read(index) for index in range(15)), series.timing)
    copied = SOUNDS[name] != "pcm_s16le"
    assert written.notices == (() if copied else ("the sound was re-encoded from pcm_s16le to AAC",))
    with av.open(str(tmp_path / "out.mp4")) as container:
        blocks = [frame.to_ndarray()[0] for frame in container.decode(audio=0)]
        rate = container.streams.audio[0].rate
    heard = np.concatenate(blocks).astype(float)
    assert len(heard) / rate == pytest.approx(0.6, abs=0.06)
    spectrum = np.abs(np.fft.rfft(heard[: rate // 2]))
    assert np.argmax(spectrum) * rate / (rate // 2) == pytest.approx(440, abs=4)


def test_sound_that_is_lost_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    series = open_series(encoded(tmp_path / "in.mp4", frames(3), sound="aac"))
    without(monkeypatch, "PyAV", "ffmpeg")
    written = write_video(tmp_path / "out.mp4", (series.read(index) for index in range(3)), series.timing)
    assert written.notices[0].startswith("sound is not kept")


def test_sound_starts_with_the_picture(tmp_path: Path) -> None:
    """A stream whose pictures begin late: sound before them is left out, the rest is not moved."""
    given = tmp_path / "in.ts"
    encoded(tmp_path / "all.ts", frames(15), times=[0.3 + index / 25 for index in range(15)], sound="aac")
    (tmp_path / "all.ts").rename(given)
    series = open_series(given)
    write_video(tmp_path / "out.mp4", (series.read(index) for index in range(15)), series.timing)
    with av.open(str(tmp_path / "out.mp4")) as container:
        ends = {one.type: one.duration * one.time_base for one in container.streams}
        starts = {one.type: (one.start_time or 0) * one.time_base for one in container.streams}
    assert starts["audio"] - starts["video"] == pytest.approx(0, abs=0.03)
    assert ends["audio"] == pytest.approx(0.3, abs=0.06)


def test_uneven_times_and_pixel_shape_are_kept(tmp_path: Path) -> None:
    times = [0, 0.04, 0.2, 0.24, 0.6, 1.0, 1.04]
    given = encoded(tmp_path / "in.mp4", frames(7), times=times, aspect=Fraction(16, 15))
    series = open_series(given)
    write_video(tmp_path / "out.mp4", (series.read(index) for index in range(7)), series.timing)
    clip = open_clip(tmp_path / "out.mp4")
    assert clip.frame_times == pytest.approx(times, abs=1e-3)
    assert clip.pixel_aspect == pytest.approx(16 / 15)


def test_the_shape_of_pixels_turns_with_the_picture(tmp_path: Path) -> None:
    given = turned(encoded(tmp_path / "in.mp4", frames(3), aspect=Fraction(4, 3)))
    series = open_series(given)
    write_video(tmp_path / "out.mp4", (series.read(index) for index in range(3)), series.timing)
    assert (
        open_clip(tmp_path / "out.mp4").pixel_aspect == open_clip(given).pixel_aspect == pytest.approx(3 / 4)
    )


def test_a_name_with_a_colon_is_a_file(tmp_path: Path, encoder: str) -> None:
    path = tmp_path / "2026-11-22T19:04:33.mp4"
    write_video(path, iter(frames(3)), Timing(25.0))
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
    assert len(open_clip(path)) == 3


@pytest.mark.parametrize(
    ("name", "size", "codec"),
    [("w.mp4", (30000, 20), "H.264"), ("w.hevc.mp4", (30000, 20), "HEVC"), ("s.hevc.mp4", (8, 8), "HEVC")],
)
def test_a_size_that_a_codec_cannot_hold_is_one_line(
    tmp_path: Path, name: str, size: tuple[int, int], codec: str
) -> None:
    frame = np.full((size[1], size[0], 3), 90, np.uint8)
    with pytest.raises(UserError) as told:
        write_video(tmp_path / name, iter([frame] * 2), Timing(25.0))
    said = str(told.value)
    assert said.startswith(f"{codec} cannot hold frames of {size[0]}x{size[1]} (")
    assert said.endswith(f"; write to a folder instead: {tmp_path / name}")
    assert not list(tmp_path.iterdir())


def test_interlaced_video_is_enhanced_and_made_again(tmp_path: Path, vesselsplat: Cli) -> None:
    """One picture a field when asked, and replayed the same."""
    given = encoded(
        tmp_path / "in.mp4", [woven(moment) for moment in range(6)], options=INTERLACED, interlaced=True
    )
    out = tmp_path / "out.mp4"
    call = vesselsplat("enhance", given, out, "--deinterlacing", "field")
    assert (call.code, "one image per field" in call.error) == (0, True)
    assert (len(open_clip(out)), open_clip(out).frames_per_second) == (12, 50.0)
    assert json.loads((tmp_path / "out.mp4.json").read_text())["pictures"][0]["deinterlacing"] == "field"
    assert "identical" in vesselsplat("replay", out).out


WRITES = """
import sys
from pathlib import Path
from typing import IO, Any
import cv2
import numpy as np
from app.files.timing import Timing
from app.files.video import write_video
from app.files.video_encoder import VideoEncoder, video_encoder
rough = np.random.default_rng(0).integers(0, 255, (37, 82, 3), np.uint8)
picture = cv2.resize(rough, (648, 290), interpolation=cv2.INTER_CUBIC)
write_video(Path(sys.argv[1]), (np.roll(picture, 3 * shift, 1) for shift in range(24)), Timing(15.0))
"""


def test_one_video_becomes_the_same_bytes_whatever_lay_in_memory(tmp_path: Path) -> None:
    """glibc fills what it hands out with the byte that is asked for; elsewhere this writes it three times."""
    written = []
    for byte in ("1", "85", "170"):
        path = tmp_path / f"{byte}.mp4"
        environment = {**os.environ, "MALLOC_PERTURB_": byte}
        root = Path(__file__).resolve().parents[3]
        subprocess.run([sys.executable, "-c", WRITES, path], env=environment, cwd=root, check=True)
        written.append(path.read_bytes())
    assert written[0] == written[1] == written[2]
