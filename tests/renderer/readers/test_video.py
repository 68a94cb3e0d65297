"""Videos: any frame in any order, times, colours, interlaced and damaged files, and refusals."""

from __future__ import annotations

import gc
import os
import random
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from renderer.clip import Clip, ClipError
from renderer.readers.clip_options import ClipOptions
from renderer.readers.video import open_video
from renderer.readers.video_decoding.video_index import decoded, open_container, video_stream
from renderer.readers.video_header import read_video_header
from renderer.sources import open_clip
from tests.renderer.readers.numbered import (
    INTERLACED,
    bar,
    encoded,
    number_of,
    numbered_picture,
    opencv_video,
    turned,
    woven,
)

DATA = Path(__file__).resolve().parents[3] / "../shared/data/clips"
LENGTH = 100


@pytest.fixture(params=["PyAV", "OpenCV alone"])
def decoder(request, monkeypatch) -> str:
    if request.param == "OpenCV alone":
        monkeypatch.setattr("renderer.readers.video.has_pyav", lambda: False)
    return request.param


@pytest.fixture(scope="module", params=[("a.mp4", "mp4v"), ("b.avi", "MJPG"), ("c.mkv", "mp4v")], ids=str)
def video(request, tmp_path_factory) -> Path:
    name, code = request.param
    return opencv_video(tmp_path_factory.mktemp("video") / name, code, LENGTH)


def numbers(clip: Clip) -> list[int]:
    return [number_of(clip.read_image(index)) for index in range(len(clip))]


def test_any_frame_in_any_order_is_the_right_one(video, decoder):
    clip = open_video(video)
    assert (len(clip), clip.size, clip.format, clip.frames_per_second) == (LENGTH, (128, 64), "video", 25.0)
    assert not clip.has_depth
    assert clip.notices == ()
    assert clip.frame_times == pytest.approx([index / 25 for index in range(LENGTH)], abs=1e-3)
    order = [*range(LENGTH), *range(LENGTH - 1, -1, -1), *random.Random(5).choices(range(LENGTH), k=60)]
    assert [number_of(clip.read_image(index)) for index in order] == order
    frame = clip.read_frame(40)
    assert (frame.index, frame.time, number_of(frame.image)) == (40, 0.4, 40)
    assert frame.tissue_mask.all()
    assert frame.evaluation_mask.all()
    assert frame.depth is None


@pytest.mark.parametrize(
    "options", [{"bf": "3", "g": "40"}, {"bf": "3", "g": "40", "x264-params": "open-gop=1"}]
)
@pytest.mark.parametrize("suffix", ["mp4", "mkv", "ts"])
def test_frames_that_are_stored_out_of_order(tmp_path, decoder, options, suffix):
    path = encoded(
        tmp_path / f"a.{suffix}", [numbered_picture(number) for number in range(90)], options=options
    )
    clip = open_video(path)
    order = random.Random(7).choices(range(90), k=40)
    assert len(clip) == 90
    assert [number_of(clip.read_image(index)) for index in order] == order


def test_threads_share_a_clip(video, decoder):
    clip = open_video(video)
    order = random.Random(6).choices(range(LENGTH), k=60)
    with ThreadPoolExecutor(4) as pool:
        assert [number_of(image) for image in pool.map(clip.read_image, order)] == order


def test_seeking_of_opencv_that_lands_elsewhere_is_noticed(video, monkeypatch):
    """A decoder whose seeks overshoot by three frames still gives the right pictures."""

    class Crooked:
        def __init__(self, *args):
            self._capture = decoder(*args)

        def __getattr__(self, name):
            return getattr(self._capture, name)

        def set(self, property, value):
            landed = value + 3 if property == cv2.CAP_PROP_POS_FRAMES else value
            return self._capture.set(property, landed)

    decoder = cv2.VideoCapture
    monkeypatch.setattr(cv2, "VideoCapture", Crooked)
    monkeypatch.setattr("renderer.readers.video.has_pyav", lambda: False)
    clip = open_video(video)
    order = [90, 3, 50, 97, 20]
    assert [number_of(clip.read_image(index)) for index in order] == order


def test_seeking_that_lands_elsewhere_is_noticed(video, monkeypatch):
    """The same with PyAV: a container whose seeks overshoot."""

    class Crooked:
        def __init__(self, container):
            self._container = container

        def __getattr__(self, name):
            return getattr(self._container, name)

        def __enter__(self):
            return self

        def __exit__(self, *args):
            self._container.close()

        def seek(self, stamp, *, stream):
            self._container.seek(stamp + round(0.2 / stream.time_base), stream=stream, backward=False)

    opened = av.open
    monkeypatch.setattr(av, "open", lambda *args, **named: Crooked(opened(*args, **named)))
    clip = open_video(video)
    order = [90, 3, 50, 97, 20]
    assert [number_of(clip.read_image(index)) for index in order] == order


@pytest.mark.parametrize(("name", "code"), [("a.avi", "MJPG"), ("b.mkv", "mp4v")])
def test_of_a_cut_video_the_whole_frames_remain(tmp_path, decoder, name, code):
    path = opencv_video(tmp_path / name, code, LENGTH)
    content = path.read_bytes()
    path.write_bytes(content[: int(0.6 * len(content))])
    clip = open_video(path)
    assert 40 < len(clip) < 70
    assert numbers(clip) == list(range(len(clip)))
    # What OpenCV makes of the header may be no more than a guess, and Matroska tells a length alone.
    of_all = f" of {LENGTH}" if decoder == "PyAV" and name.endswith("avi") else ""
    assert f": {len(clip)}{of_all} frames are whole" in clip.notices[0]
    with pytest.raises(IndexError, match=f"from 0 to {len(clip) - 1}, got {len(clip)}"):
        clip.read_image(len(clip))


def test_of_a_cut_mp4_the_whole_frames_remain(tmp_path, decoder):
    """Whose index, at the start, tells of all."""
    whole = tmp_path / "whole.mp4"
    with av.open(str(whole), "w", container_options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height = 128, 64
        for number in range(LENGTH):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(numbered_picture(number), "rgb24")))
        container.mux(stream.encode())
    content = whole.read_bytes()
    path = tmp_path / "cut.mp4"
    path.write_bytes(content[: int(0.6 * len(content))])
    clip = open_video(path)
    assert 30 < len(clip) < 75
    assert numbers(clip) == list(range(len(clip)))
    assert "cut off" in clip.notices[0]


def test_a_video_of_one_frame(tmp_path, decoder):
    clip = open_video(opencv_video(tmp_path / "one.avi", "MJPG", 1))
    assert len(clip) == 1
    assert clip.test_indices == ()
    assert number_of(clip.read_image(0)) == 0


def test_an_empty_file_is_refused(tmp_path, decoder):
    (tmp_path / "empty.mp4").touch()
    with pytest.raises(ClipError, match=r"got an empty file: .*empty\.mp4$"):
        open_video(tmp_path / "empty.mp4")


def test_what_is_no_video_is_refused(tmp_path, decoder):
    path = tmp_path / "text.mp4"
    path.write_bytes(b"not a video\n" * 40)
    with pytest.raises(ClipError, match=r"neither, or a damaged one: .*text\.mp4$"):
        open_video(path)


def test_a_video_that_was_cut_off_is_told_apart_from_what_is_none(tmp_path, decoder):
    path = tmp_path / "half.mp4"
    path.write_bytes(b"\x00\x00\x00\x18ftypisom" + bytes(300))
    with pytest.raises(ClipError, match=r"got a damaged video, or one that was cut off: .*half\.mp4$"):
        open_video(path)


def test_a_video_path_that_is_not_utf8_is_refused(tmp_path, decoder):
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.mp4"))
    path.write_bytes(b"anything")
    with pytest.raises(ClipError, match="UTF-8"):
        open_video(path)


@pytest.mark.parametrize("suffix", ["mp4", "mkv"])
def test_no_frame_of_a_varying_rate_is_lost_and_times_are_kept(tmp_path, decoder, suffix):
    steps = random.Random(3).choices([40, 80, 120, 360], k=49)
    times = [sum(steps[:index]) / 1000 for index in range(50)]
    pictures = [numbered_picture(number) for number in range(50)]
    clip = open_video(encoded(tmp_path / f"vfr.{suffix}", pictures, times=times))
    assert numbers(clip) == list(range(50))
    assert not any("cut off" in notice for notice in clip.notices)
    if decoder == "PyAV" or suffix == "mp4":
        assert clip.frame_times == pytest.approx(times, abs=2e-3)
    if suffix == "mp4":
        # Muxers count the last frame among those, but not always its time.
        assert read_video_header(clip.path).frames_per_second == pytest.approx(49 / times[-1], rel=0.03)
    if decoder == "PyAV":
        assert clip.frames_per_second == pytest.approx(49 / times[-1], rel=1e-3)
        assert any("rate varies" in notice for notice in clip.notices)
        assert clip.every(2).frame_times == pytest.approx(times[::2], abs=2e-3)


CODECS = {
    "h264.mp4": ("libx264", INTERLACED, "yuv420p"),
    "h264.ts": ("libx264", INTERLACED, "yuv420p"),
    "mpeg2.ts": ("mpeg2video", {"flags": "+ildct+ilme", "qmin": "1", "qscale": "1"}, "yuv420p"),
    "prores.mov": ("prores_ks", {"flags": "+ildct+ilme", "field_order": "tt"}, "yuv422p10le"),
    "ffv1.mkv": ("ffv1", {"field_order": "tt"}, "yuv422p"),
}


@pytest.mark.parametrize("name", CODECS)
def test_interlaced_video_is_deinterlaced(tmp_path, name):
    """The bar is where the first field has it, straight, in every frame, in any order."""
    codec, options, pixels = CODECS[name]
    path = encoded(
        tmp_path / name,
        [woven(moment) for moment in range(20)],
        codec,
        options=options,
        pixels=pixels,
        interlaced=True,
    )
    clip = open_video(path)
    assert len(clip) == 20
    assert any("interlaced" in notice for notice in clip.notices)
    in_order = [clip.read_image(index) for index in range(20)]
    for moment in range(1, 19):
        error = np.abs(in_order[moment].astype(int) - bar(2 * moment))
        assert error.mean() < 3, moment
        lines = in_order[moment].astype(int)[:, :, 1]
        assert np.abs(np.diff(lines, axis=0)).mean() < 2, moment
    for index in (13, 2, 19, 0, 7):
        np.testing.assert_array_equal(clip.read_image(index), in_order[index])


def test_one_picture_a_field_or_as_stored_when_asked(tmp_path):
    path = encoded(
        tmp_path / "a.mp4", [woven(moment) for moment in range(20)], options=INTERLACED, interlaced=True
    )
    fields = open_clip(path, ClipOptions(deinterlacing="field"))
    assert (len(fields), fields.frames_per_second) == (40, 50.0)
    assert fields.frame_times == pytest.approx([index / 50 for index in range(40)], abs=1e-6)
    for field in range(2, 38):
        assert np.abs(fields.read_image(field).astype(int) - bar(field)).mean() < 3, field
    one = encoded(tmp_path / "one.mp4", [woven(0)], options=INTERLACED, interlaced=True)
    assert open_clip(one, ClipOptions(deinterlacing="field")).frame_times == pytest.approx([0, 0.02])
    stored = open_clip(path, ClipOptions(deinterlacing="off"))
    assert np.abs(stored.read_image(5).astype(int) - woven(5)).mean() < 2
    assert "not deinterlaced" in stored.notices[0]


def test_opencv_alone_refuses_what_it_does_not_decode(tmp_path, monkeypatch):
    """It reports success for interlaced frames, and gives stray memory."""
    path = encoded(
        tmp_path / "a.mp4", [woven(moment) for moment in range(20)], options=INTERLACED, interlaced=True
    )
    monkeypatch.setattr("renderer.readers.video.has_pyav", lambda: False)
    with pytest.raises(ClipError, match="interlaced video; install PyAV to read more"):
        open_video(path)


@pytest.mark.parametrize("matrix", [1, 6])
def test_levels_are_those_of_the_source(tmp_path, matrix):
    """Within a tenth of a grey level on average, in each colour, whichever matrix the file names."""
    rough = np.random.default_rng(4).uniform(30, 220, (9, 9, 3)).astype(np.float32)
    picture = np.clip(cv2.resize(rough, (256, 256), interpolation=cv2.INTER_CUBIC), 0, 255).astype(np.uint8)
    path = encoded(tmp_path / "a.mp4", [picture] * 3, options={"crf": "1"}, matrix=matrix)
    apart = open_video(path).read_image(1).astype(int) - picture
    assert np.abs(apart.mean(axis=(0, 1))).max() < 0.1
    assert np.abs(apart).mean() < 1.5


@pytest.mark.parametrize(("height", "matrix"), [(720, "ITU709"), (576, "ITU601")])
def test_a_video_that_names_no_matrix_is_read_as_players_do(tmp_path, height, matrix):
    picture = np.full((height, 64, 3), (200, 60, 50), np.uint8)
    path = tmp_path / "a.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25, options={"crf": "1"})
        stream.width, stream.height, stream.pix_fmt = 64, height, "yuv420p"
        frame = av.VideoFrame.from_ndarray(picture, "rgb24").reformat(format="yuv420p", dst_colorspace=matrix)
        frame.colorspace = 2
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    assert np.abs(open_video(path).read_image(0)[height // 2, 32].astype(int) - (200, 60, 50)).max() <= 3


def test_pixels_that_are_not_square(tmp_path):
    pictures = [numbered_picture(number) for number in range(3)]
    clip = open_video(encoded(tmp_path / "a.mp4", pictures, aspect=Fraction(16, 11)))
    assert clip.pixel_aspect == pytest.approx(16 / 11)
    camera = clip.cameras[0]
    assert camera.fy / camera.fx == pytest.approx(16 / 11)
    assert any("1.45 times as wide as high" in notice for notice in clip.notices)


def test_what_rounding_leaves_of_a_size_is_square(tmp_path):
    """FFmpeg writes such a shape when it makes a video smaller."""
    pictures = [numbered_picture(number) for number in range(3)]
    clip = open_video(encoded(tmp_path / "a.mp4", pictures, aspect=Fraction(1120, 1119)))
    assert clip.pixel_aspect == 1
    assert not any("as wide as high" in notice for notice in clip.notices)


def test_a_turned_video_is_upright(tmp_path):
    clip = open_video(turned(encoded(tmp_path / "a.mp4", [numbered_picture(number) for number in range(5)])))
    assert clip.size == (64, 128)
    assert [number_of(np.rot90(clip.read_image(number))) for number in range(5)] == list(range(5))


@pytest.mark.parametrize(
    ("across", "down", "shown"),
    [
        ((-1, 0), (0, 1), lambda stored: stored[:, ::-1]),
        ((1, 0), (0, -1), lambda stored: stored[::-1]),
        ((-1, 0), (0, -1), lambda stored: stored[::-1, ::-1]),
        ((0, -1), (1, 0), lambda stored: np.rot90(stored)),
        ((0, 1), (1, 0), lambda stored: stored.transpose(1, 0, 2)),
        ((0, -1), (-1, 0), lambda stored: np.rot90(stored, 2).transpose(1, 0, 2)),
    ],
)
def test_a_mirrored_video_is_read_as_players_show_it(tmp_path, across, down, shown):
    stored = encoded(tmp_path / "a.mp4", [numbered_picture(number) for number in range(3)])
    wanted = shown(open_video(stored).read_image(1))
    told = turned(shutil.copy(stored, tmp_path / "b.mp4"), across, down)
    np.testing.assert_array_equal(open_video(told).read_image(1), wanted)


def test_a_stream_without_times(tmp_path):
    """Raw H.264 tells no times: frames are counted."""
    path = encoded(
        tmp_path / "a.h264", [numbered_picture(number) for number in range(40)], options={"g": "10"}
    )
    clip = open_video(path)
    assert (len(clip), clip.frames_per_second) == (40, 25.0)
    order = random.Random(2).choices(range(40), k=20)
    assert [number_of(clip.read_image(index)) for index in order] == order


@pytest.mark.data
@pytest.mark.skipif(not DATA.is_dir(), reason="the clips are not there")
def test_a_real_video(decoder):
    video = open_video(DATA / "laparoscopy_1280x720.mp4")
    assert (len(video), video.size, video.frames_per_second) == (250, (1280, 720), 25.0)
    ahead = video.read_image(150)
    for index in (149, 3, 200):
        video.read_image(index)
    np.testing.assert_array_equal(video.read_image(150), ahead)


def test_a_video_that_is_open_when_the_program_ends_says_nothing(video, monkeypatch):
    troubles = []
    monkeypatch.setattr(sys, "unraisablehook", lambda trouble: troubles.append(trouble.exc_value))
    with open_container(video) as container:
        frames = decoded(container, video_stream(container, video))
        next(frames)
        with monkeypatch.context() as ending:
            ending.setattr(av, "error", None)  # Modules are emptied before what they have made.
            del frames
            gc.collect()
    assert troubles == []
