"""The sound of a video that is rewritten: copied, or re-encoded where the new one cannot hold it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import chain
from typing import TYPE_CHECKING, cast

import av

from app.files.codecs import Container
from app.files.timing import Timing
from renderer.readers.video_decoding.video_index import open_container, start_of

if TYPE_CHECKING:
    from av.audio.codeccontext import AudioCodecContext
    from av.audio.stream import AudioStream
    from av.container import InputContainer, OutputContainer
    from av.packet import Packet
    from av.stream import Stream

    _Timed = tuple[float, Packet[AudioStream]]

LAYOUTS = {1: "mono", 2: "stereo"}
"""By the number of channels."""
UNNAMED = "channels"
"""In what FFmpeg says of channels whose places have no name together."""
BEYOND = 0.5
"""Seconds of sound after the last frame that are lost without a word: encoders fill their last block."""
LISTED = 6
"""Channels of AAC beyond which its decoder lists them one by one: PyAV 18 frees such lists twice."""


def sound_of(timing: Timing, output: OutputContainer, within: Container) -> Sound | None:
    """The first sound track of the video that frames come from, with a track for it in `output`, if any."""
    if timing.like is None or not timing.has_sound:
        return None
    source = open_container(timing.like)
    if not source.streams.audio:
        source.close()
        return None
    return Sound(source, output, within, start_of(timing.like) + Fraction(timing.start))


class Sound:
    """Feeds the output in step with its frames, so that players find both close to each other."""

    def __init__(
        self, source: InputContainer, output: OutputContainer, within: Container, start: Fraction
    ) -> None:
        # Times count from the first frame that is written: sound before it has no picture.
        self._source, self._output, self._within, self._start = source, output, within, start
        self._track = source.streams.audio[0]
        self._extra = len(source.streams.audio) - 1
        # None where this FFmpeg does not know the codec, whatever PyAV's types say.
        decoder: AudioCodecContext | None = self._track.codec_context
        self._codec = "unknown codec" if decoder is None else decoder.name
        self._is_copied = decoder is not None and decoder.codec.canonical_name in within.sounds
        self._decoder = decoder
        self._mixed = ""
        self._written = self._add_track()
        self._packets = self._copied() if self._is_copied else self._encoded()
        self._waiting: _Timed | None = None
        self._failure = ""

    def write_until(self, seconds: float) -> None:
        """All that begins before this time of the output."""
        while (ready := self._waiting or self._next()) and ready[0] < seconds:
            self._waiting = None
            self._output.mux(ready[1])
        self._waiting = ready

    def finish(self, end: float) -> tuple[str, ...]:
        """One sentence for each loss. end: of the last frame, in seconds of the output."""
        codec, said = self._codec, list[str]()
        if self._written is None:
            said.append(f"the sound ({codec}) is left out: it cannot be encoded to {self._within.sound_name}")
        elif self._failure:
            said.append(
                f"the sound ({codec}) is kept up to the point where it cannot be decoded: {self._failure}"
            )
        elif not self._is_copied:
            said.append(f"the sound was re-encoded from {codec} to {self._within.sound_name}{self._mixed}")
        if self._written is not None and (rest := self._rest(end)) > BEYOND:
            said.append(f"the sound goes on for {rest:.1f} s after the last frame: this is left out")
        if self._extra:
            said.append(f"only the first of {self._extra + 1} sound tracks is kept")
        return tuple(said)

    def _rest(self, end: float) -> float:
        """Seconds of sound after the last frame of the source; 0 where it does not tell, or has more."""
        of_sound, of_video = map(self._end_of, (self._track, self._source.streams.best("video")))
        is_whole = of_video is not None and abs(of_video - end) < BEYOND
        return 0.0 if of_sound is None or not is_whole else of_sound - end

    def _end_of(self, stream: Stream | None) -> float | None:
        """In seconds of the output."""
        if stream is None or stream.duration is None or stream.time_base is None:
            return None
        return float(((stream.start_time or 0) + stream.duration) * stream.time_base - self._start)

    def close(self) -> None:
        self._source.close()

    def _add_track(self) -> AudioStream | None:
        """None: no encoder takes it."""
        if self._is_copied:
            return self._output.add_stream_from_template(self._track)
        if self._decoder is None:
            return None
        given = named_layout(self._decoder)
        if self._codec.startswith("aac") and av.AudioLayout(given).nb_channels > LISTED:
            return None
        rate = self._within.sound_rate or _rate(self._within.sound, self._track.rate)
        layouts = () if UNNAMED in given else (given, LAYOUTS[2])
        taken = next((one for one in layouts if _opens(self._within.sound, rate, one)), None)
        if taken is None:
            return None
        self._mixed = "" if taken == given else " in stereo"
        self._mixed += "" if rate >= self._track.rate else f" at {rate / 1000:g} kHz"
        added = self._output.add_stream(self._within.sound, rate=rate, layout=taken)
        return cast("AudioStream", added)

    def _next(self) -> _Timed | None:
        try:
            return next(self._packets, None)
        except av.error.FFmpegError as error:
            self._failure = error.strerror or type(error).__name__
        except ValueError as error:  # Of PyAV, where channels or rate change on the way.
            self._failure = str(error)
        return None

    def _copied(self) -> Iterator[_Timed]:
        if self._written is None:
            return
        line = _Line()
        for packet in self._source.demux(self._track):
            if packet.pts is None or not packet.size:
                continue
            base = packet.time_base
            packet.pts = line.placed(packet.pts, packet.duration or 0) - round(self._start / base)
            packet.dts = packet.pts
            if packet.pts >= 0:
                packet.stream = self._written
                yield float(packet.pts * base), packet

    def _encoded(self) -> Iterator[_Timed]:
        if self._written is None:
            return
        line = _Line()
        for frame in chain(self._source.decode(self._track), (None,)):
            if frame is not None and frame.pts is not None:
                # In samples, since the units of some files are too coarse for the encoder's blocks.
                at = round((frame.pts * (frame.time_base or 0) - self._start) * frame.rate)
                frame.pts, frame.time_base = line.placed(at, frame.samples), Fraction(1, frame.rate)
                if frame.pts < 0:
                    continue
            for packet in self._written.encode(frame):
                yield float((packet.pts or 0) * packet.time_base), packet


class _Line:
    """The times of pieces that follow each other: where they begin anew, as in joined files, they go on."""

    def __init__(self) -> None:
        self._shift, self._end = 0, 0
        self._begin: int | None = None

    def placed(self, begin: int, length: int) -> int:
        """When the piece begins in the whole, in the units of `begin`."""
        if self._begin is not None and begin + self._shift < self._begin:
            self._shift = self._end - begin
        self._begin = begin + self._shift
        self._end = self._begin + length
        return self._begin


def named_layout(decoder: AudioCodecContext) -> str:
    """Of the sound that it will give, if it is not at work yet: that of the file, or the usual one of as many
    channels.

    The layout is put in the place of channels listed one by one, which PyAV 18 would free twice, and of those
    that only have a number, which no encoder takes.
    """
    given = decoder.layout
    number, name = given.nb_channels, given.name
    decoder.layout = LAYOUTS.get(number) or (_usual(number) if UNNAMED in name else name)
    return decoder.layout.name


def _usual(channels: int) -> str:
    """Of as many channels; of some numbers there is none, and they stay without a place."""
    try:
        return av.AudioLayout(f"{channels}c").name
    except ValueError:
        return f"{channels}C"


def _rate(encoder: str, given: int) -> int:
    """The given rate, or the next higher one that the encoder takes, or its highest."""
    taken = av.Codec(encoder, "w").audio_rates or [given]
    return min((rate for rate in taken if rate >= given), default=max(taken))


def _opens(encoder: str, rate: int, layout: str) -> bool:
    """Whether the encoder takes sound of this kind; a stream tells only once its file is begun."""
    context = cast("AudioCodecContext", av.CodecContext.create(encoder, "w"))
    formats = context.codec.audio_formats
    assert formats
    context.rate, context.layout = rate, av.AudioLayout(layout)
    context.format = formats[0]
    try:
        context.open()
    except av.error.FFmpegError:
        return False
    return True
