"""Pictures and videos whose frames carry their number, so that any frame says which one it is."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

BITS = 7


def numbered_picture(number: int) -> np.ndarray:
    """(64, 128, 3) uint8 with the number written as a row of white and black blocks."""
    picture = np.full((64, 128, 3), 60, dtype=np.uint8)
    for bit in range(BITS):
        picture[16:48, 18 * bit + 2 : 18 * bit + 16] = 230 if number >> bit & 1 else 10
    return picture


def number_of(picture: np.ndarray) -> int:
    blocks = [picture[22:42, 18 * bit + 5 : 18 * bit + 13].mean() > 128 for bit in range(BITS)]
    return sum(1 << bit for bit, white in enumerate(blocks) if white)


def opencv_video(path: Path, code: str, length: int) -> Path:
    """Numbered frames, 25 a second, without sound."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 25.0, (128, 64))
    assert writer.isOpened()
    for number in range(length):
        writer.write(numbered_picture(number))
    writer.release()
    return path


def encoded(
    path: Path,
    pictures: Sequence[np.ndarray],
    codec: str = "libx264",
    *,
    pixels: str = "yuv420p",
    options: dict[str, str] | None = None,
    times: Sequence[float] | None = None,
    sound: str | None = None,
    sound_seconds: float | None = None,
    matrix: int = 1,
    aspect: Fraction | None = None,
    interlaced: bool = False,
) -> Path:
    """A video of 25 frames a second, or with its frames at `times` in seconds; `sound` names a codec,
    whose track lasts as long, or `sound_seconds`.

    `interlaced` marks frames as two fields, the upper lines first.
    """
    from av.video.reformatter import Interpolation as Flags

    exact = Flags.BICUBIC | Flags.ACCURATE_RND | Flags.FULL_CHR_H_INT
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=25, options=options or {})
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = pixels
        unit = Fraction(1, 25) if times is None else Fraction(1, 1000)
        stream.codec_context.time_base = unit
        stream.codec_context.colorspace = matrix
        if aspect is not None:
            stream.codec_context.sample_aspect_ratio = aspect
        track = container.add_stream(sound, rate=48000, layout="stereo") if sound else None
        for number, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(picture, "rgb24")
            names = {1: "ITU709", 6: "ITU601", 2: "ITU601"}
            frame = frame.reformat(format=pixels, dst_colorspace=names[matrix], interpolation=exact)
            if interlaced:
                frame = marked(frame)
            frame.pts = number if times is None else round(1000 * times[number])
            frame.time_base = unit
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
        if track is not None:
            for block in tone(sound_seconds or len(pictures) / 25):
                container.mux(track.encode(block))
            container.mux(track.encode())
    return path


def marked(frame: av.VideoFrame) -> av.VideoFrame:
    """The same frame, marked as two fields, the upper lines first."""
    graph = av.filter.Graph()
    frame.pts, frame.time_base = 0, Fraction(1, 1000)
    source = graph.add_buffer(
        width=frame.width, height=frame.height, format=frame.format, time_base=frame.time_base
    )
    graph.link_nodes(source, graph.add("setfield", "tff"), graph.add("buffersink")).configure()
    graph.vpush(frame)
    return graph.vpull()


def tone(seconds: float) -> list[av.AudioFrame]:
    """A beep of 440 Hz at 48 kHz."""
    samples = (0.3 * np.sin(2 * np.pi * 440 * np.arange(int(48000 * seconds)) / 48000)).astype(np.float32)
    blocks = []
    for start in range(0, len(samples), 960):
        block = av.AudioFrame.from_ndarray(np.tile(samples[start : start + 960], (2, 1)), "fltp", "stereo")
        block.sample_rate, block.pts, block.time_base = 48000, start, Fraction(1, 48000)
        blocks.append(block)
    return blocks


INTERLACED = {"flags": "+ildct+ilme", "x264-params": "tff=1", "crf": "4"}
"""For H.264 with the top field first."""


def woven(moment: int, height: int = 64, width: int = 128) -> np.ndarray:
    """A frame of two fields: a bright bar that moves by 2 px a field over a ramp, upper lines first."""
    fields = [bar(2 * moment), bar(2 * moment + 1)]
    frame = fields[0].copy()
    frame[1::2] = fields[1][1::2]
    return frame[:height, :width]


def bar(field: int) -> np.ndarray:
    """(64, 128, 3) with a bar 16 px wide whose left edge is at 8 + 2 field."""
    picture = np.repeat(np.tile(np.linspace(40, 90, 128), (64, 1))[..., None], 3, axis=2).astype(np.uint8)
    picture[:, 8 + 2 * field : 24 + 2 * field] = 210
    return picture


def turned(path: Path, across: tuple[int, int] = (0, 1), down: tuple[int, int] = (-1, 0)) -> Path:
    """The same .mp4, now told to be shown turned by a quarter; or so that a step across and a step down its
    stored frames go these ways, right and down."""
    content = path.read_bytes()
    identity, told = (
        b"".join(struct.pack(">3i", x << 16, y << 16, 0) for x, y in steps)
        + struct.pack(">3i", 0, 0, 1 << 30)
        for steps in (((1, 0), (0, 1)), (across, down))
    )
    at = content.index(identity, content.index(b"tkhd"))
    path.write_bytes(content[:at] + told + content[at + len(told) :])
    return path
