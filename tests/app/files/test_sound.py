"""Sound of many channels and rates: it is kept as far as the new video can hold it, and losses are told."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from app.files.image_series import open_series
from app.files.video import Written, write_video
from tests.app.files.test_video import frames
from tests.renderer.readers.numbered import encoded

COUNT = 10
"""Frames, at 25 a second."""


def with_sound(
    path: Path, layout: str, channels: int, rate: int, seconds: Fraction = Fraction(COUNT, 25)
) -> Path:
    """A video with a beep of PCM of 16 bits in all channels."""
    silent = encoded(path.with_name("silent.mp4"), frames(COUNT))
    with av.open(str(silent)) as source, av.open(str(path), "w") as container:
        pictures = source.streams.video[0]
        stream = container.add_stream_from_template(pictures)
        track = container.add_stream("pcm_s16le", rate=rate, layout=layout)
        for packet in source.demux(pictures):
            if packet.dts is not None:
                packet.stream = stream
                container.mux(packet)
        wave = 8000 * np.sin(2 * np.pi * 440 * np.arange(int(rate * seconds)) / rate)
        levels = np.repeat(wave.astype(np.int16), channels)[None]
        block = av.AudioFrame.from_ndarray(levels, "s16", layout)
        block.sample_rate, block.pts, block.time_base = rate, 0, Fraction(1, rate)
        container.mux(track.encode(block))
        container.mux(track.encode())
    silent.unlink()
    return path


def rewritten(given: Path, out: Path) -> Written:
    series = open_series(given)
    return write_video(out, (series.read(index) for index in range(len(series))), series.timing)


def heard(path: Path) -> tuple[float, int]:
    """Pitch of the loudest tone in Hz, and channels of the sound in a video of ours."""
    with av.open(str(path)) as container:
        track = container.streams.audio[0]
        blocks = [frame.to_ndarray() for frame in container.decode(track)]
        rate = track.rate
    wave = np.concatenate([block[0] for block in blocks]).astype(float)
    return float(np.argmax(np.abs(np.fft.rfft(wave))) * rate / len(wave)), len(blocks[0])


def seconds_of_sound(path: Path) -> float:
    with av.open(str(path)) as container:
        packets = container.demux(container.streams.audio[0])
        return max(float((one.pts or 0) * one.time_base) for one in packets if one.size)


KINDS = {
    "in-2.1.mov": ("2.1", 3, 48_000),
    "in-4.0.mov": ("4.0", 4, 48_000),
    "in-5.1.mkv": ("5.1", 6, 48_000),
    "in-7.1.mov": ("7.1", 8, 48_000),
    "in-16.mov": ("hexadecagonal", 16, 48_000),
    "in-quick.mov": ("mono", 1, 192_000),
    "in-slow.mov": ("mono", 1, 4_000),
}
"""As recorders of SDI write them; layout, channels and rate."""


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("ending", [".mp4", ".webm"])
def test_sound_of_any_channels_and_rate_is_heard(tmp_path: Path, name: str, ending: str) -> None:
    layout, channels, rate = KINDS[name]
    out = tmp_path / f"out{ending}"
    written = rewritten(with_sound(tmp_path / name, layout, channels, rate), out)
    assert seconds_of_sound(out) == pytest.approx(COUNT / 25, abs=0.15)
    (said,) = written.notices
    assert said.startswith("the sound was re-encoded from pcm_s16le to ")
    if channels <= 6:  # PyAV itself may crash over more.
        pitch, kept = heard(out)
        assert pitch == pytest.approx(440, abs=5)
        assert kept == (2 if said.endswith(" in stereo") else channels)
    assert (" at " in said) == (rate > 96_000)
    assert len(open_series(out)) == COUNT


def test_sound_whose_channels_have_no_place_is_left_out_and_told(tmp_path: Path) -> None:
    given, out = with_sound(tmp_path / "in.mkv", "9C", 9, 48_000), tmp_path / "out.mp4"
    written = rewritten(given, out)
    assert written.notices == ("the sound (pcm_s16le) is left out: it cannot be encoded to AAC",)
    with av.open(str(out)) as container:
        assert not container.streams.audio
    assert len(open_series(out)) == COUNT


def test_sound_of_an_unknown_codec_is_left_out_and_told(tmp_path: Path) -> None:
    given, out = with_sound(tmp_path / "in.mov", "mono", 1, 48_000), tmp_path / "out.mp4"
    content = given.read_bytes()
    assert content.count(b"sowt") == 1
    given.write_bytes(content.replace(b"sowt", b"@@@@"))
    written = rewritten(given, out)
    assert written.notices == ("the sound (unknown codec) is left out: it cannot be encoded to AAC",)
    assert len(open_series(out)) == COUNT


def test_aac_of_many_channels_is_copied_or_left_out_and_told(tmp_path: Path) -> None:
    given = with_sound(tmp_path / "in.mov", "7.1", 8, 48_000)
    rewritten(given, tmp_path / "aac.mp4")
    assert rewritten(tmp_path / "aac.mp4", tmp_path / "again.mp4").notices == ()
    said = rewritten(tmp_path / "aac.mp4", tmp_path / "out.webm").notices
    assert said == ("the sound (aac) is left out: it cannot be encoded to Opus",)
    assert len(open_series(tmp_path / "out.webm")) == COUNT


@pytest.mark.parametrize("ending", [".mp4", ".webm"])
def test_sound_of_streams_put_end_to_end_goes_on(tmp_path: Path, ending: str) -> None:
    parts = [encoded(tmp_path / f"{number}.ts", frames(COUNT), sound="aac") for number in range(3)]
    given, out = tmp_path / "in.ts", tmp_path / f"out{ending}"
    given.write_bytes(b"".join(part.read_bytes() for part in parts))
    rewritten(given, out)
    assert len(open_series(out)) == 3 * COUNT
    assert seconds_of_sound(out) == pytest.approx(3 * COUNT / 25, abs=0.15)


@pytest.mark.parametrize(("seconds", "is_told"), [(Fraction(2), True), (Fraction(1, 2), False)])
def test_sound_that_goes_on_after_the_last_frame_is_told(
    tmp_path: Path, seconds: Fraction, is_told: bool
) -> None:
    given = with_sound(tmp_path / "in.mov", "mono", 1, 48_000, seconds)
    said = "the sound goes on for 1.6 s after the last frame: this is left out"
    assert (said in rewritten(given, tmp_path / "out.mp4").notices) == is_told
