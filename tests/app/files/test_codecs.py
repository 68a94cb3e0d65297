"""VP9 and HEVC: the same frames, times, colours and sound as in H.264, and the same bytes twice."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from app.__main__ import main
from app.commands.view_selection import LEAST_RATE
from app.errors import UserError
from app.files.codecs import CODECS, HEVC, MP4, WEBM, ending_of
from app.files.image_series import open_series
from app.files.pyav_writing import rate_of
from app.files.timing import Timing
from app.files.video import write_video
from renderer.sources import open_clip
from tests.app.conftest import Call, Cli
from tests.app.files.test_video import RED, frames, read, without
from tests.renderer.readers.numbered import encoded

ENDINGS = [WEBM, HEVC]
NAMES = {MP4: "h264", WEBM: "vp9", HEVC: "hevc"}


@pytest.mark.parametrize("ending", ENDINGS)
def test_frames_times_and_colours_come_back(tmp_path: Path, ending: str) -> None:
    given, times = frames(7), (0.0, 0.04, 0.08, 0.2, 0.24, 0.28, 0.4)
    path = tmp_path / f"out{ending}"
    written = write_video(path, iter(given), Timing(25.0, times))
    assert written.encoding.startswith(CODECS[ending].name)
    clip = open_clip(path)
    assert clip.frame_times is not None
    assert clip.frame_times == pytest.approx(times, abs=0.001)
    for index, before in enumerate(given):
        after = clip.read_image(index).astype(int)
        assert np.abs(after - before).mean() < 6
        assert np.abs(after[30:, 40:] - RED).max() <= 4
    with av.open(str(path)) as container:
        codec = container.streams.video[0].codec_context
        assert codec.name in (NAMES[ending], f"lib{NAMES[ending]}", "libvpx-vp9")
        assert (codec.color_primaries, codec.color_trc, codec.colorspace) == (1, 1, 1)
    assert len(read(path)[0]) == 7  # OpenCV's own FFmpeg.


@pytest.mark.parametrize("ending", [MP4, *ENDINGS])
@pytest.mark.parametrize("rate", [LEAST_RATE, 0.0006, 0.4])
def test_a_time_lapse_keeps_its_rate(tmp_path: Path, ending: str, rate: float) -> None:
    path = tmp_path / f"out{ending}"
    write_video(path, iter(frames(4)), Timing(rate))
    clip = open_clip(path)
    assert clip.frames_per_second == pytest.approx(rate, rel=1e-3)
    assert len(clip) == 4


@pytest.mark.parametrize(
    ("rate", "kept"),
    [(29.97, (2997, 100)), (30000 / 1001, (30000, 1001)), (25.0, (25, 1)), (1 / 3600, (1, 3600))],
)
def test_rates_are_kept_as_fractions_of_small_numbers(rate: float, kept: tuple[int, int]) -> None:
    assert rate_of(rate).as_integer_ratio() == kept


@pytest.mark.parametrize("ending", [MP4, *ENDINGS])
def test_the_same_frames_are_the_same_bytes(tmp_path: Path, ending: str) -> None:
    paths = [tmp_path / f"{name}{ending}" for name in "ab"]
    for path in paths:
        write_video(path, iter(frames(9, 90, 130)), Timing(25.0))
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize(("ending", "kept"), [(WEBM, ["libopus"]), (HEVC, ["aac", "libopus"])])
@pytest.mark.parametrize("sound", ["aac", "libopus", "pcm_s16le"])
def test_sound_is_copied_or_encoded_again_as_the_container_has_it(
    tmp_path: Path, ending: str, kept: list[str], sound: str
) -> None:
    given = {"aac": "in.mp4", "libopus": "in.mkv", "pcm_s16le": "in.mov"}[sound]
    series = open_series(encoded(tmp_path / given, frames(15), sound=sound))
    path = tmp_path / f"out{ending}"
    written = write_video(path, (series.read(index) for index in range(15)), series.timing)
    said = f"to {'Opus' if ending == WEBM else 'AAC'}"
    assert [said in notice for notice in written.notices] == ([] if sound in kept else [True])
    with av.open(str(path)) as container:
        heard = np.concatenate([frame.to_ndarray()[0] for frame in container.decode(audio=0)])
        rate = container.streams.audio[0].rate
    with av.open(str(tmp_path / given)) as container:
        before = sum(frame.samples for frame in container.decode(audio=0)) / container.streams.audio[0].rate
    assert len(heard) / rate == pytest.approx(before, abs=0.1)
    assert np.abs(heard.astype(float)).max() > 0


@pytest.mark.parametrize("ending", [MP4, *ENDINGS])
def test_the_shape_of_pixels_is_kept_or_its_loss_told(tmp_path: Path, ending: str) -> None:
    series = open_series(encoded(tmp_path / "in.mp4", frames(3), aspect=Fraction(4, 3)))
    path = tmp_path / f"out{ending}"
    written = write_video(path, (series.read(index) for index in range(3)), series.timing)
    shown = open_clip(path).pixel_aspect
    if ending == WEBM:
        (said,) = written.notices
        assert said.startswith("pixels are 1.33 times as wide as high, which .webm does not keep")
        assert shown == 1
    else:
        assert written.notices == ()
        assert shown == pytest.approx(4 / 3)


def test_a_video_is_enhanced_into_webm_and_made_again(tmp_path: Path, vesselsplat: Cli) -> None:
    given = encoded(tmp_path / "in.mp4", frames(5))
    out = tmp_path / "out.webm"
    done: Call = vesselsplat("enhance", given, out)
    assert (done.code, done.error) == (0, "")
    with out.open("rb") as file:
        assert file.read(4) == b"\x1a\x45\xdf\xa3"
    again = vesselsplat("replay", out, "--source", given)
    assert again.out.rstrip().endswith("identical")


@pytest.mark.parametrize("ending", ENDINGS)
def test_without_pyav_it_is_refused_before_anything_is_made(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    given, out = encoded(tmp_path / "in.mp4", frames(3)), tmp_path / f"out{ending}"
    without(monkeypatch, "PyAV")
    with pytest.raises(UserError, match="VP9 and HEVC need PyAV"):
        write_video(out, iter(frames(2)), Timing(25.0))
    assert main(["enhance", str(given), str(out)]) == 2
    said = capfd.readouterr().err.splitlines()[-1]
    assert f"or a name that ends in .mp4: {out}" in said
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]


@pytest.mark.parametrize(
    ("name", "ending"),
    [
        ("a.mp4", MP4),
        ("A.MP4", MP4),
        ("a.hevc.mp4", HEVC),
        ("hevc.mp4", MP4),
        ("a.WebM", WEBM),
        ("a.avi", ""),
    ],
)
def test_the_ending_of_the_name_says_the_codec(name: str, ending: str) -> None:
    assert ending_of(Path(name)) == ending
