"""Which frames a video file holds and when each is shown, from its packets and a few decoded frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, pairwise
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, Literal

from renderer.budget import OverBudget, budget
from renderer.clip import ClipError
from renderer.readers.dicom.opening import is_dicom
from renderer.readers.dicom.stream import StreamFile, ends_early
from renderer.readers.misnamed import JPEG_XL, neither, what_it_is
from renderer.utf8_paths import not_utf8

if TYPE_CHECKING:
    from av import VideoFrame
    from av.container import InputContainer
    from av.stream import Stream
    from av.video.stream import VideoStream

HEAD = 8
"""Frames decoded at the start, to see whether packets tell of frames, and whether they are interlaced."""
LATER = 4
"""Places over the rest of the file where it is looked whether frames are interlaced."""
TAIL = 16
"""Packets at the end of which some may be cut off: their frames are decoded to know."""
SLACK = 2
"""Frames by which headers err: AVI counts one that is not there."""
LOST = 0.5
"""Seconds that are missing from a file that is cut off."""
ERRORS = 100
"""Places where a file may be damaged before the rest is given up."""
DICOM_HOLDS = "mov,mp4,mpegts,mpeg,mpegvideo,h264,hevc"
"""Forms of video in it, as FFmpeg calls them."""
SMOOTH = 8
"""Units of time in a frame from which on a difference of one unit is rounding."""
Threads = Literal["AUTO", "SLICE"]
NO_VIDEO = frozenset({"ansi", "bintext", "xbin", "idf", "exr", "hdr"})
"""Text, of which FFmpeg makes pictures, and images of light, of which it makes grey levels without a word."""


@dataclass(frozen=True)
class VideoIndex:
    """The frames of a video that decode, in the order in which they are shown."""

    stamps: tuple[int, ...]
    """Of each frame, in units of `time_base`; its number where the file does not tell."""
    time_base: Fraction
    """Seconds."""
    is_counted: bool
    """Whether frames are known by their number alone."""
    is_cut: bool
    """Whether the end of the file is missing or damaged."""
    is_interlaced: bool
    nominal_rate: Fraction
    """Frames a second as the file says it."""
    announced: int = 0
    """Frames that the header tells; 0: it does not."""
    last_size: tuple[int, int] | None = None
    """Width and height of the last frame as it is stored, where it was decoded."""
    threads: Threads = "AUTO"
    """Of a decoder that counts these very frames."""

    @property
    def is_steady(self) -> bool:
        """Whether frames come evenly."""
        steps = [later - one for one, later in pairwise(self.stamps)]
        return not steps or max(steps) - min(steps) <= (median(steps) >= SMOOTH)

    @property
    def frames_per_second(self) -> Fraction:
        """The file's own rate where its frames come evenly, else their number by the time they take."""
        if len(self.stamps) > 1:
            unit = self.time_base / (len(self.stamps) - 1)
            mean = (self.stamps[-1] - self.stamps[0]) * unit
            if not self.is_steady or abs(mean - 1 / self.nominal_rate) > unit:
                return 1 / mean
        return self.nominal_rate

    @property
    def times(self) -> tuple[float, ...]:
        """Seconds from the first frame, rising."""
        return tuple(float((stamp - self.stamps[0]) * self.time_base) for stamp in self.stamps)


def open_container(path: Path) -> InputContainer:
    """Raises ClipError when the file is no video, or its path is not UTF-8."""
    import av

    if said := not_utf8(path):
        raise ClipError(said)
    # As a plain file: a name with a colon is no address, and nothing that the file refers to is fetched.
    address: Any = f"file:{path.absolute()}"
    local = {"protocol_whitelist": "file"}
    if is_dicom(path):
        address = StreamFile(path)
        local |= {"format_whitelist": DICOM_HOLDS} | address.rate
    try:
        container: InputContainer = av.open(address, metadata_errors="replace", container_options=local)
        return container
    except (av.error.FFmpegError, OSError, ValueError) as error:
        raise ClipError(neither(path)) from error


def video_stream(container: InputContainer, path: Path, threads: Threads = "SLICE") -> VideoStream:
    """The moving pictures of a container; a cover picture is none. `threads` decode frames side by side with
    "AUTO", which is quick; with "SLICE" frames come one after the other, and so the same of a damaged end
    each time.

    Raises:
        ClipError: there are none, this FFmpeg cannot decode them, or they are the tiles of an image.
    """
    from av.stream import Disposition

    found = [one for one in container.streams.video if not one.disposition & Disposition.attached_pic]
    if not found:
        holds = "only sound" if container.streams.audio else "no video track"
        raise ClipError(f"expected a video, got a file with {holds}: {path}")
    # FFmpeg gives the tiles of a HEIC or AVIF image one by one; a video has one such stream at most.
    if (tiles := sum(bool(one.disposition & Disposition.dependent) for one in found)) > 1:
        got = f"got one of {tiles} tiles: convert it to PNG or JPEG first"
        raise ClipError(f"expected an image in one piece, {got}: {path}")
    best = container.streams.best("video")
    stream = next((one for one in found if one is best), found[0])
    if stream.codec_context is None and what_it_is(path) == JPEG_XL:
        raise ClipError(neither(path))
    if stream.codec_context is None:
        raise ClipError(f"expected a video that FFmpeg decodes, got an unknown codec: {path}")
    if stream.codec_context.name in NO_VIDEO:
        raise ClipError(neither(path))
    try:
        budget().require(pixels=stream.codec_context.width * stream.codec_context.height)
    except OverBudget as error:
        raise ClipError(f"{error}: {path}") from error
    stream.thread_type = threads
    return stream


def decoded(container: InputContainer, stream: VideoStream) -> Iterator[VideoFrame]:
    """Whole frames from where the container is, in order; damaged packets and frames are passed over."""
    # The name itself: the module may be emptied before a generator that is left at the program's end.
    from av.error import FFmpegError

    for packet in _packets_of(container, stream):
        try:
            frames = packet.decode()
        except FFmpegError:
            continue
        yield from (frame for frame in frames if not frame.is_corrupt)


def _packets_of(container: InputContainer, stream: VideoStream, *others: Stream) -> Iterator[Any]:
    """From where the container is to its end; behind damage it goes on."""
    from av.error import FFmpegError

    for _ in range(ERRORS):
        try:
            yield from container.demux(stream, *others)
        except FFmpegError:
            continue
        return


def index_of(path: Path) -> VideoIndex:
    """Reads the whole file once, and decodes no more than its first and last frames where its packets tell.

    Raises:
        ClipError: no video, or no frame that decodes.
    """
    scan = _scanned(path)
    return _timed(path, scan) or _numbered(path, scan)


def _numbered(path: Path, scan: _Scan) -> VideoIndex:
    """Of a file whose packets do not tell when frames are shown: all are decoded."""
    threads = scan.packets.threads
    with open_container(path) as container:
        stream = video_stream(container, path, threads)
        flags, size = list[bool](), None
        for frame in decoded(container, stream):
            flags.append(frame.interlaced_frame)
            size = frame.width, frame.height
    return VideoIndex(
        stamps=tuple(range(len(flags))),
        time_base=1 / scan.rate,
        is_counted=True,
        is_cut=scan.packets.is_short or len(flags) < len(scan.packets.stamps),
        is_interlaced=any(flags),
        nominal_rate=scan.rate,
        announced=scan.packets.announced,
        last_size=size,
        threads=threads,
    )


def told_index(path: Path) -> VideoIndex | None:
    """The same where packets tell it, and so quickly, and of a file that is cut off, whose whole frames are
    counted; else None. Raises as `index_of`."""
    scan = _scanned(path)
    return _timed(path, scan) or (_numbered(path, scan) if scan.packets.is_short else None)


@dataclass(frozen=True)
class _Scan:
    """A file that was read once."""

    packets: _Packets
    head: tuple[int | None, ...]
    """When the first frames that decode are shown."""
    time_base: Fraction
    rate: Fraction
    is_interlaced: bool
    is_sure: bool
    """Whether its container tells of no frame that is not there."""


def _scanned(path: Path) -> _Scan:
    with open_container(path) as container:
        stream = video_stream(container, path)
        time_base, rate = stream.time_base or Fraction(1, 25), nominal_rate(stream)
        packets = _packets(container, stream)
        sure = "mp4" in container.format.name
    if is_dicom(path) and ends_early(path):
        packets = replace(packets, is_short=True)
    with open_container(path) as container:
        stream = video_stream(container, path, packets.threads)
        head = list(islice(decoded(container, stream), HEAD))
    if not head:
        raise ClipError(f"expected a video, got a file without a frame that decodes: {path}")
    interlaced = any(frame.interlaced_frame for frame in head) or _interlaced_later(path, packets)
    return _Scan(packets, tuple(frame.pts for frame in head), time_base, rate, interlaced, sure)


def _interlaced_later(path: Path, packets: _Packets) -> bool:
    """Whether frames are that come well after the first ones, as behind a title or a menu."""
    from av.error import FFmpegError

    if not packets.are_timed or len(packets.stamps) <= HEAD:
        return False
    with open_container(path) as container:
        stream = video_stream(container, path)
        for place in range(1, LATER + 1):
            try:
                container.seek(packets.stamps[place * (len(packets.stamps) - 1) // LATER], stream=stream)
            except (FFmpegError, OSError):
                return False
            if any(frame.interlaced_frame for frame in islice(decoded(container, stream), 1)):
                return True
    return False


def _timed(path: Path, scan: _Scan) -> VideoIndex | None:
    first, packets = scan.head[0], scan.packets
    stamps = [stamp for stamp in packets.stamps if first is not None and stamp >= first]
    if not packets.are_timed or scan.head != tuple(stamps[: len(scan.head)]):
        return None
    whole, size = (
        (stamps, None) if scan.is_sure and not packets.is_short else _whole(path, stamps, packets.threads)
    )
    return VideoIndex(
        stamps=tuple(whole),
        time_base=scan.time_base,
        is_counted=False,
        is_cut=packets.is_short or len(whole) < len(stamps),
        is_interlaced=scan.is_interlaced,
        nominal_rate=scan.rate,
        announced=packets.announced,
        last_size=size,
    )


def start_of(path: Path) -> Fraction:
    """Seconds at which the first frame that decodes is shown; 0 where the file does not tell.

    Raises:
        ClipError: no video.
    """
    with open_container(path) as container:
        stream = video_stream(container, path)
        first = next(decoded(container, stream), None)
        if first is None or first.pts is None or stream.time_base is None:
            return Fraction(0)
        return first.pts * stream.time_base


def rate_of(stream: VideoStream) -> Fraction | None:
    """Frames a second as the file says it, if it does."""
    told = (rate for rate in (stream.guessed_rate, stream.average_rate) if rate and 0 < rate < 1000)
    return next(told, None)


def nominal_rate(stream: VideoStream) -> Fraction:
    """The same, or as usual in Europe."""
    return rate_of(stream) or Fraction(25)


@dataclass(frozen=True)
class _Packets:
    """What the packets of a file tell."""

    stamps: list[int]
    """In the order in which frames are shown."""
    are_timed: bool
    """Whether each says when it is shown; in joined files times begin anew, and say nothing."""
    is_short: bool
    """Whether the header announces more, or the last packets are damaged."""
    announced: int
    """Frames that the header tells; 0: it does not."""
    tells_end: bool
    """Whether the header announces frames or a length, so that a damaged end shows."""

    @property
    def threads(self) -> Threads:
        """With which the frames at the end, of which the last may be damaged, are the same each time."""
        return "AUTO" if self.tells_end and not self.is_short else "SLICE"


def _packets(container: InputContainer, stream: VideoStream) -> _Packets:
    stamps, order, damaged, untimed, count = list[int](), list[int](), 0, 0, 0
    tells_length, end = "matroska" in container.format.name, 0.0
    # The length that the header tells is that of the longest track, of subtitles too.
    others = [one for one in container.streams if one.index != stream.index] if tells_length else ()
    for packet in _packets_of(container, stream, *others):
        if not packet.size:
            continue
        if tells_length and packet.pts is not None:
            end = max(end, float((packet.pts + (packet.duration or 0)) * packet.time_base))
        if packet.stream_index != stream.index:
            continue
        count += 1
        damaged = count if packet.is_corrupt else damaged
        untimed += packet.pts is None
        if packet.pts is not None and not packet.is_discard:
            stamps.append(packet.pts)
        if packet.dts is not None:
            order.append(packet.dts)
    short = stream.frames - count > SLACK or 0 < count - TAIL < damaged or 0 < damaged >= count
    if tells_length and stamps and container.duration:
        # The header tells the length of all, in microseconds, once the file was closed.
        short |= container.duration / 1e6 - end > LOST
    kept = sorted(set(stamps))
    begin_anew = len(kept) < len(stamps) or any(later < one for one, later in pairwise(order))
    tells_end = stream.frames > 0 or bool(tells_length and container.duration)
    return _Packets(kept, not untimed and not begin_anew, short, stream.frames, tells_end)


def _whole(path: Path, stamps: list[int], threads: Threads) -> tuple[list[int], tuple[int, int] | None]:
    """The stamps without those at the end whose frames do not decode, and the size of the last frame."""
    start = stamps[max(0, len(stamps) - TAIL)]
    with open_container(path) as container:
        stream = video_stream(container, path, threads)
        container.seek(start, stream=stream)
        seen = _sizes(container, stream)
    if start not in seen:
        with open_container(path) as container:
            seen = _sizes(container, video_stream(container, path, threads))
    whole = [stamp for stamp in stamps if stamp < start or stamp in seen]
    return whole, seen.get(whole[-1])


def _sizes(container: InputContainer, stream: VideoStream) -> dict[int | None, tuple[int, int]]:
    """Width and height by the stamp of each frame that comes."""
    return {frame.pts: (frame.width, frame.height) for frame in decoded(container, stream)}
