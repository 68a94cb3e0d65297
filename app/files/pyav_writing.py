"""Videos by PyAV: frames at their own times, with the colour tags and the sound of their source."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

import av
from av.video.reformatter import Interpolation

from app.errors import UserError
from app.files.codecs import BT470BG, BT601, BT709, BT2020, Codec
from app.files.image_files import ArrayImage
from app.files.sound import Sound, sound_of
from app.files.timing import Timing
from renderer.readers.video_decoding.video_index import decoded, open_container, video_stream
from renderer.readers.video_decoding.video_shape import UNSPECIFIED, pixel_aspect, usual_matrix

if TYPE_CHECKING:
    from av.video.stream import VideoStream

MATRICES = {BT709: "ITU709", 4: "FCC", BT470BG: "ITU601", BT601: "ITU601", 7: "SMPTE240M", BT2020: "BT2020"}
"""Of the codes of ITU-T H.273, as swscale calls them."""
TICKS = 90_000
"""Units of a second for frames that do not come evenly, as in broadcasting."""
# Without these, swscale rounds down: whole pictures become darker by a grey level.
EXACT = (
    Interpolation.BICUBIC
    | Interpolation.ACCURATE_RND
    | Interpolation.FULL_CHR_H_INT
    | Interpolation.FULL_CHR_H_INP
)


@dataclass(frozen=True)
class _Tags:
    """What the source says of its colours and pixels."""

    primaries: int = BT709
    transfer: int = BT709
    matrix: int = BT709
    pixel_aspect: Fraction | None = None


@contextmanager
def encoded(codec: str, size: tuple[int, int], instead: str = "") -> Iterator[None]:
    """Raises UserError, with what to do `instead`: the encoder fails. OSError, as of a full disk, passes."""
    try:
        yield
    except av.error.FFmpegError as error:
        if isinstance(error, OSError):
            raise
        frames = f"frames of {size[0]}x{size[1]} ({error.strerror})"
        raise UserError(f"{codec} cannot hold {frames}{instead}") from error


class PyavWriter:
    """One frame after another, then the rest of the sound."""

    def __init__(self, path: Path, size: tuple[int, int], timing: Timing, codec: Codec) -> None:
        tags = _Tags() if timing.like is None else _tags(timing.like)
        within = codec.container
        self.notices = _unkept(tags, codec)
        # As a plain file: a name with a colon is no address.
        place, options = f"file:{path.absolute()}", dict(within.options)
        self._container = av.open(place, "w", format=within.name, container_options=options)
        self._rate = rate_of(timing.frames_per_second)
        self._unit = 1 / self._rate if timing.frame_times is None else Fraction(1, TICKS)
        self._stream = self._video_stream(size, tags, codec)
        self._matrix = MATRICES.get(tags.matrix) or usual_matrix(size[1])
        self._sound: Sound | None = sound_of(timing, self._container, within)
        self._count, self._end = 0, 0.0
        self._encoded = partial(encoded, codec.name, size, f"; write to a folder instead: {path}")
        self.encoding = f"{codec.name}, colour tags {tags.primaries}/{tags.transfer}/{tags.matrix}"

    def _video_stream(self, size: tuple[int, int], tags: _Tags, made_by: Codec) -> VideoStream:
        added = self._container.add_stream(made_by.encoder, rate=self._rate, options=dict(made_by.options))
        stream = cast("VideoStream", added)
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        codec = stream.codec_context
        codec.time_base = self._unit
        codec.color_primaries, codec.color_trc, codec.colorspace = tags.primaries, tags.transfer, tags.matrix
        codec.color_range = 1
        if made_by.tag is not None:
            codec.codec_tag = made_by.tag
        if tags.pixel_aspect is not None:
            codec.sample_aspect_ratio = tags.pixel_aspect
        return stream

    def write(self, frame: ArrayImage, seconds: float | None) -> None:
        start = float(self._count / self._rate) if seconds is None else seconds
        picture = encodable(frame, self._matrix)
        picture.pts = self._count if seconds is None else round(seconds * TICKS)
        picture.time_base = self._unit
        self._count += 1
        self._end = start + float(1 / self._rate)
        with self._encoded():
            self._container.mux(self._stream.encode(picture))
        if self._sound is not None:
            self._sound.write_until(start)

    def finish(self) -> None:
        with self._encoded():
            self._container.mux(self._stream.encode())
        if self._sound is not None:
            self._sound.write_until(self._end)
            self.notices += self._sound.finish(self._end)

    def close(self) -> None:
        if self._sound is not None:
            self._sound.close()
        self._container.close()


def rate_of(frames_per_second: float) -> Fraction:
    """The nearest of 1001 or less in the smaller of its numbers, which 30000/1001 has and an hour a frame."""
    if frames_per_second < 1:
        return 1 / Fraction(1 / frames_per_second).limit_denominator(1001)
    return Fraction(frames_per_second).limit_denominator(1001)


def _unkept(tags: _Tags, codec: Codec) -> tuple[str, ...]:
    """A sentence, where images will be shown as if their pixels were square."""
    if tags.pixel_aspect is None or codec.container.keeps_pixel_shape:
        return ()
    ratio, name = f"{float(tags.pixel_aspect):.3g}", codec.container.name
    return (
        f"pixels are {ratio} times as wide as high, which .{name} does not keep: players show them square; "
        "a name that ends in .mp4 keeps their shape",
    )


def encodable(frame: ArrayImage, matrix: str) -> av.VideoFrame:
    """An (H, W, 3) RGB uint8 frame as the encoder takes it, by one of MATRICES."""
    return av.VideoFrame.from_ndarray(frame, "rgb24").reformat(
        format="yuv420p", dst_colorspace=matrix, dst_color_range=1, interpolation=EXACT
    )


def _tags(path: Path) -> _Tags:
    """Of a video; a matrix that this writer has no use for gives way to BT.709.

    Browsers heed a matrix only beside primaries and a transfer: what is missing is that of screens.
    """
    with open_container(path) as container:
        stream = video_stream(container, path)
        codec = stream.codec_context
        matrix = int(codec.colorspace)
        known = matrix if matrix in MATRICES or matrix == UNSPECIFIED else BT709
        first = next(decoded(container, stream), None)
        aspect = Fraction(1) if first is None else pixel_aspect(stream, first)
        shape = None if aspect == 1 else aspect
        missing = UNSPECIFIED if known == UNSPECIFIED else BT709
        primaries, transfer = (
            missing if told == UNSPECIFIED else int(told) for told in (codec.color_primaries, codec.color_trc)
        )
        return _Tags(primaries, transfer, known, shape)
