"""Which videos end before they should, and that others keep their last frame where OpenCV reads alone."""

from __future__ import annotations

from pathlib import Path

import av
import pytest

from renderer.readers.video_decoding.container_end import ends_early
from renderer.readers.video_decoding.opencv_video import OpenCvVideo
from renderer.readers.video_decoding.pyav_video import PyAvVideo
from renderer.readers.video_header import read_counted_header, read_video_header
from tests.renderer.readers.numbered import encoded, number_of, numbered_picture, opencv_video

LENGTH = 60


def later(source: Path, path: Path, ticks: int) -> Path:
    """The same packets, shown `ticks` of their time base later."""
    with av.open(str(source)) as given, av.open(str(path), "w") as container:
        stream = container.add_stream_from_template(given.streams.video[0])
        for packet in given.demux(video=0):
            if packet.dts is not None and packet.pts is not None:
                packet.pts += ticks
                packet.dts += ticks
                packet.stream = stream
                container.mux(packet)
    return path


def numbers(video) -> list[int]:
    return [number_of(video.read(index)) for index in range(len(video))]


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    pictures = [numbered_picture(number) for number in range(LENGTH)]
    return encoded(tmp_path_factory.mktemp("whole") / "whole.mp4", pictures)


@pytest.mark.parametrize("name", ["late.mkv", "late.mp4", "late.mov"])
def test_a_clip_that_starts_late_keeps_its_last_frame(tmp_path, whole, name):
    clip = OpenCvVideo(later(whole, tmp_path / name, 2 * 12800))
    assert numbers(clip) == list(range(LENGTH))
    assert clip.notices == ()


def test_a_clip_whose_edit_list_leaves_out_its_beginning_keeps_its_last_frame(tmp_path, whole):
    path = later(whole, tmp_path / "edited.mp4", -25 * 512)
    clip = OpenCvVideo(path)
    assert numbers(clip) == numbers(PyAvVideo(path)) == list(range(25, LENGTH))
    assert clip.notices == ()


@pytest.mark.parametrize("name", ["late.mkv", "late.mp4", "late.ts"])
def test_a_clip_that_starts_late_is_no_longer_for_it(tmp_path, whole, name):
    path = later(whole, tmp_path / name, 100 * 12800)
    for read in (read_video_header, read_counted_header):
        assert read(path).seconds == pytest.approx(LENGTH / 25, abs=0.05)


@pytest.mark.parametrize("length", [2, 10, LENGTH])
def test_the_last_frame_of_an_avi_with_b_frames_is_read(tmp_path, length):
    pictures = [numbered_picture(number) for number in range(length)]
    clip = OpenCvVideo(encoded(tmp_path / "a.avi", pictures, "mpeg4", options={"bf": "2"}))
    assert numbers(clip) == list(range(length))
    order = [length - 1, 0, length - 2, length - 1, length // 2, length - 1]
    assert [number_of(clip.read(index)) for index in order] == order
    assert clip.frame_times == pytest.approx([number / 25 for number in range(length)])
    assert clip.notices == ()


@pytest.mark.parametrize("name", ["sound.mkv", "sound.mp4"])
def test_sound_that_lasts_longer_takes_no_frame(tmp_path, name):
    pictures = [numbered_picture(number) for number in range(LENGTH)]
    whole = encoded(tmp_path / name, pictures, sound="aac", sound_seconds=4)
    clip = OpenCvVideo(whole)
    assert numbers(clip) == list(range(LENGTH))
    assert clip.notices == ()


@pytest.mark.parametrize(("name", "code"), [("a.avi", "MJPG"), ("b.mkv", "mp4v"), ("c.mp4", "mp4v")])
def test_a_file_without_its_end_ends_early(tmp_path, name, code):
    path = opencv_video(tmp_path / name, code, LENGTH)
    assert not ends_early(path)
    path.write_bytes(path.read_bytes()[:-1])
    assert ends_early(path)


def test_a_file_that_states_no_length_does_not_end_early(tmp_path):
    path = opencv_video(tmp_path / "a.mkv", "mp4v", LENGTH)
    content = path.read_bytes()
    at = content.index(bytes.fromhex("18538067")) + 4
    path.write_bytes(content[:at] + b"\x01" + 7 * b"\xff" + content[at + 8 : -100])
    assert not ends_early(path)


@pytest.mark.parametrize(
    "content", [b"", b"G" * 400, b"RIFF", b"\x1a\x45\xdf\xa3", b"\0\0\0\0ftyp" + bytes(99)]
)
def test_other_files_do_not_end_early(tmp_path, content):
    path = tmp_path / "a.mp4"
    path.write_bytes(content)
    assert not ends_early(path)
