"""The sound of a video that is rewritten: copied, or re-encoded where the new one cannot hold it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import chain
from typing import TYPE_CHECKING, cast

import av

from app.files.codecs import Container
from app.files.timing import Timing
from renderer.readers.video_index import open_container, start_of

if TYPE_CHECKING:
    from av.audio.stream import AudioStream
    from av.container import InputContainer, OutputContainer
    from av.packet import Packet

LAYOUTS = {1: "mono", 2: "stereo"}
"""By the number of channels."""


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
        self._is_copied = self._track.codec_context.codec.canonical_name in within.sounds
        self._written = self._add_track()
        packets = self._copied() if self._is_copied else self._encoded()
        self._packets: Iterator[tuple[float, Packet[AudioStream]]] = packets
        self._waiting: tuple[float, Packet[AudioStream]] | None = None
        self._failure = ""

    def write_until(self, seconds: float) -> None:
        """All that begins before this time of the output."""
        while (ready := self._waiting or self._next()) and ready[0] < seconds:
            self._waiting = None
            self._output.mux(ready[1])
        self._waiting = ready

    def finish(self) -> tuple[str, ...]:
        """One sentence for each loss."""
        codec = self._track.codec_context.name
        said = []
        if self._failure:
            said.append(
                f"the sound ({codec}) is kept up to the point where it cannot be decoded: {self._failure}"
            )
        elif not self._is_copied:
            said.append(f"the sound was re-encoded from {codec} to {self._within.sound_name}")
        if self._extra:
            said.append(f"only the first of {self._extra + 1} sound tracks is kept")
        return tuple(said)

    def close(self) -> None:
        self._source.close()

    def _add_track(self) -> AudioStream:
        if self._is_copied:
            return self._output.add_stream_from_template(self._track)
        channels = self._track.codec_context.channels
        # Some files tell the number of channels alone, which the encoder does not take.
        layout = LAYOUTS.get(channels, self._track.layout.name)
        rate = self._within.sound_rate or self._track.rate
        added = self._output.add_stream(self._within.sound, rate=rate, layout=layout)
        return cast("AudioStream", added)

    def _next(self) -> tuple[float, Packet[AudioStream]] | None:
        try:
            return next(self._packets, None)
        except av.error.FFmpegError as error:
            self._failure = error.strerror or type(error).__name__
            return None

    def _copied(self) -> Iterator[tuple[float, Packet[AudioStream]]]:
        for packet in self._source.demux(self._track):
            if packet.pts is None or not packet.size:
                continue
            base = packet.time_base
            packet.pts -= round(self._start / base)
            packet.dts = packet.pts
            if packet.pts >= 0:
                packet.stream = self._written
                yield float(packet.pts * base), packet

    def _encoded(self) -> Iterator[tuple[float, Packet[AudioStream]]]:
        for frame in chain(self._source.decode(self._track), (None,)):
            if frame is not None and frame.pts is not None:
                # In samples, since the units of some files are too coarse for the encoder's blocks.
                seconds = frame.pts * (frame.time_base or 0) - self._start
                frame.pts, frame.time_base = round(seconds * frame.rate), Fraction(1, frame.rate)
                if frame.pts < 0:
                    continue
            for packet in self._written.encode(frame):
                yield float((packet.pts or 0) * packet.time_base), packet
