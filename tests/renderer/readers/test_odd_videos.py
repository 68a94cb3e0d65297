"""Videos that are cut off, change on the way, or are none: what is whole is read, the rest is one line."""

from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import ExifTags, Image

from renderer.clip import ClipError
from renderer.readers.clip_options import ClipOptions
from renderer.readers.video import open_video
from renderer.readers.video_decoding import pyav_video
from renderer.readers.video_decoding.pyav_video import PyAvVideo
from renderer.readers.video_header import read_video_header
from tests.renderer.readers.numbered import (
    INTERLACED,
    bar,
    encoded,
    number_of,
    numbered_picture,
    opencv_video,
    tone,
    woven,
)
from tests.renderer.readers.test_video import LENGTH, numbers


def test_of_a_cut_mkv_with_sound_the_whole_frames_remain(tmp_path):
    """Its header tells how long picture or sound last, whichever is longer."""
    whole = tmp_path / "whole.mkv"
    with av.open(str(whole), "w") as container:
        stream, sound = container.add_stream("mpeg4", rate=25), container.add_stream("pcm_s16le", rate=8000)
        stream.width, stream.height = 128, 64
        for number in range(LENGTH):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(numbered_picture(number), "rgb24")))
            noise = np.random.default_rng(number).integers(-900, 900, (1, 320), np.int16)
            heard = av.AudioFrame.from_ndarray(noise, format="s16", layout="mono")
            heard.sample_rate, heard.pts = 8000, 320 * number
            container.mux(sound.encode(heard))
        container.mux([*stream.encode(), *sound.encode()])
    assert not any("cut off" in notice for notice in open_video(whole).notices)
    content = whole.read_bytes()
    path = tmp_path / "cut.mkv"
    path.write_bytes(content[: int(0.6 * len(content))])
    clip = open_video(path)
    assert 30 < len(clip) < 75
    assert "cut off" in clip.notices[0]


def test_subtitles_that_last_longer_than_the_video_cut_nothing_off(tmp_path):
    film = encoded(tmp_path / "film.mkv", [numbered_picture(number) for number in range(10)])
    (tmp_path / "words.srt").write_text("1\n00:00:00,000 --> 00:00:08,000\nLiver\n")
    path = tmp_path / "both.mkv"
    with (
        av.open(str(film)) as seen,
        av.open(str(tmp_path / "words.srt")) as words,
        av.open(str(path), "w") as out,
    ):
        tracks = [(one, out.add_stream_from_template(one.streams[0])) for one in (seen, words)]
        for source, track in tracks:
            for packet in source.demux():
                if packet.size:
                    packet.stream = track
                    out.mux(packet)
    clip = open_video(path)
    assert (len(clip), clip.notices) == (10, ())


def test_colours_that_ffmpeg_does_not_convert_are_refused_in_a_line(tmp_path):
    pictures = [numbered_picture(number) for number in range(3)]
    path = encoded(tmp_path / "a.mkv", pictures, options={"x264-params": "colormatrix=YCgCo"}, matrix=2)
    with pytest.raises(ClipError, match=r"expected colours that FFmpeg converts.* matrix 8"):
        open_video(path)


def test_a_frame_of_another_size_is_refused_in_a_line(tmp_path):
    """Two streams one behind the other, as recorders write them when the source changes."""
    parts = []
    for name, (height, width) in (("a", (48, 64)), ("b", (80, 96))):
        with av.open(str(tmp_path / f"{name}.h264"), "w") as container:
            stream = container.add_stream("libx264", rate=25)
            stream.width, stream.height = width, height
            for number in range(4):
                grey = np.full((height, width, 3), 40 + 20 * number, np.uint8)
                container.mux(stream.encode(av.VideoFrame.from_ndarray(grey, "rgb24")))
            container.mux(stream.encode())
        parts.append((tmp_path / f"{name}.h264").read_bytes())
    path = tmp_path / "both.h264"
    path.write_bytes(b"".join(parts))
    clip = open_video(path)
    assert clip.read_image(1).shape == (48, 64, 3)
    assert clip.notices == ("frames at the end are 96x80, not 64x48 as the first one, and cannot be read",)
    wanted = "expected frames of 64x48, as the first one, got 96x80 in frame 5 of 8: "
    with pytest.raises(ClipError, match=wanted):
        clip.read_image(4)


@pytest.mark.parametrize("share", [0.5, 2 / 3])
def test_the_end_of_a_cut_video_is_the_same_each_time(tmp_path, share):
    """Its last packet decodes or does not, depending on which thread of the decoder is first."""
    y, x = np.mgrid[:128, :160]
    pictures = []
    for number in range(75):
        waves = [127 + 120 * np.sin(x / 9 + number / 3 + k) * np.cos(y / 7 - number / 5) for k in range(3)]
        pictures.append(np.stack(waves, -1).astype(np.uint8))
    options = {"bf": "3", "g": "12", "x264-params": "open-gop=1"}
    content, path = (
        encoded(tmp_path / "whole.ts", pictures, options=options).read_bytes(),
        tmp_path / "cut.ts",
    )
    path.write_bytes(content[: int(len(content) * share)])
    clips = [open_video(path) for _ in range(15)]
    assert len({len(clip) for clip in clips}) == 1
    assert all(clip.read_image(len(clip) - 1).shape == (128, 160, 3) for clip in clips)


@pytest.mark.parametrize("name", ["notes.txt", "notes.ans", "notes.nfo"])
def test_text_is_no_video(tmp_path, name):
    """FFmpeg would make pictures of it."""
    (tmp_path / name).write_text("Patient notes\n" * 300)
    with pytest.raises(ClipError, match="neither, or a damaged one"):
        open_video(tmp_path / name)


def test_sound_alone_is_no_video(tmp_path):
    path = tmp_path / "dictation.m4a"
    with av.open(str(path), "w", format="mp4") as container:
        track = container.add_stream("aac", rate=48000, layout="stereo")
        for block in tone(0.5):
            container.mux(track.encode(block))
        container.mux(track.encode())
    with pytest.raises(ClipError, match="got a file with only sound"):
        open_video(path)


def test_a_name_with_a_colon_is_a_file(tmp_path):
    path = opencv_video(tmp_path / "a.avi", "MJPG", 3)
    named = tmp_path / "2026-11-22T19:04:33.avi"
    path.rename(named)
    assert numbers(open_video(named)) == [0, 1, 2]


def test_a_playlist_fetches_nothing_from_elsewhere(tmp_path):
    """A text of addresses, of which FFmpeg would open each."""
    path = tmp_path / "list.m3u8"
    path.write_text("#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nhttp://127.0.0.1:9/a.ts\n#EXT-X-ENDLIST\n")
    with pytest.raises(ClipError):
        open_video(path)


def test_interlaced_frames_behind_a_title_are_deinterlaced(tmp_path):
    """As the wish says: as frames, as fields, or not; each with a notice."""
    title = encoded(tmp_path / "title.ts", [bar(0)] * 20)
    pictures = [woven(moment) for moment in range(20)]
    rest = encoded(tmp_path / "rest.ts", pictures, options=INTERLACED, interlaced=True)
    path = joined(tmp_path / "in.ts", title, rest, apart=90_000)
    wishes = {wish: open_video(path, ClipOptions(deinterlacing=wish)) for wish in ("frame", "field", "off")}
    assert [len(clip) for clip in wishes.values()] == [40, 80, 40]
    assert all(any("interlaced video" in notice for notice in clip.notices) for clip in wishes.values())
    for moment in range(1, 19):
        error = np.abs(wishes["frame"].read_image(20 + moment).astype(int) - bar(2 * moment))
        assert error.mean() < 3, moment


@pytest.mark.parametrize("codec", ["libx264", "mpeg2video"])
@pytest.mark.parametrize("lengths", [(20, 30), (30, 20), (25, 25)])
def test_no_frame_of_streams_put_end_to_end_is_lost(tmp_path, codec, lengths):
    """As `cat` joins them: the time stamps of the second begin anew."""
    counts = range(lengths[0]), range(lengths[0], sum(lengths))
    parts = [
        encoded(tmp_path / f"{number}.ts", [numbered_picture(one) for one in part], codec)
        for number, part in enumerate(counts)
    ]
    path = tmp_path / "in.ts"
    path.write_bytes(b"".join(part.read_bytes() for part in parts))
    clip = open_video(path)
    assert numbers(clip) == list(range(50))
    assert not any("cut off" in notice for notice in clip.notices)
    assert clip.frame_times == pytest.approx([one / 25 for one in range(50)])
    for index in (40, 3, 25, 19, 20):
        assert number_of(clip.read_image(index)) == index


def joined(path: Path, *parts: Path, apart: int) -> Path:
    """One stream of several, each beginning `apart` units of 1/90000 s after the one before."""
    with av.open(str(path), "w") as container:
        stream = None
        for number, part in enumerate(parts):
            with av.open(str(part)) as source:
                stream = stream or container.add_stream_from_template(source.streams.video[0])
                for packet in source.demux(video=0):
                    if packet.dts is not None:
                        packet.stream = stream
                        packet.pts, packet.dts = packet.pts + number * apart, packet.dts + number * apart
                        container.mux(packet)
    return path


def test_frames_that_carry_what_a_camera_says_of_itself(tmp_path):
    told = Image.Exif()
    told[ExifTags.Base.Make] = "a camera"
    still, film = tmp_path / "still.jpg", tmp_path / "film.avi"
    Image.fromarray(numbered_picture(3)).save(still, exif=told, quality=95)
    with av.open(str(film), "w") as container:
        stream = container.add_stream("mjpeg", rate=10)
        stream.width, stream.height, stream.pix_fmt = 128, 64, "yuvj420p"
        for number in range(4):
            packet = av.Packet(still.read_bytes())
            packet.stream, packet.pts, packet.dts = stream, number, number
            packet.time_base, packet.is_keyframe = Fraction(1, 10), True
            container.mux(packet)
    clip = open_video(film)
    assert [number_of(clip.read_image(index)) for index in range(len(clip))] == [3] * 4


def test_the_shape_of_pixels_is_that_of_the_decoder_that_gave_the_first_frame(tmp_path, monkeypatch):
    """Of those before it, which are closed, FFmpeg would read memory that is another's by now."""
    asked, path = [], tmp_path / "cut.mp4"
    monkeypatch.setattr(pyav_video, "pixel_aspect", lambda stream, frame: asked.append(stream) or 1)
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=25, options={"crf": "16", "preset": "veryfast"})
        stream.width, stream.height, stream.pix_fmt = 128, 64, "yuv420p"
        for number in range(9):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(numbered_picture(number), "rgb24")))
        container.mux(stream.encode())
    content = path.read_bytes()
    for share in np.arange(0.75, 0.95, 0.02):
        path.write_bytes(content[: int(share * len(content))])
        with suppress(ClipError):
            video = PyAvVideo(path)
            assert asked[-1] is video._decoder[1]
            assert read_video_header(path).size == (128, 64)
    assert asked
