"""Clips without depth: a folder of pictures, one picture, a video file."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from renderer.camera import Camera
from renderer.clip import ByteImage, Clip, ClipError, Frame
from renderer.readers.listing import listed
from renderer.readers.picture_kinds import is_named_array, kinds_of
from renderer.readers.pictures import VIDEOS, common_size, is_picture, is_visible, natural_key, read_rgb

FIELD_OF_VIEW = 60.0
"""Horizontal, in degrees: taken for endoscopes whose calibration is unknown."""

_STEP_LIMIT = 32  # Frames that are cheaper to decode in passing than to seek over.
_TAIL = 16  # A video is cut off somewhere in its last packets: as many are decoded to know where.


def open_images(path: Path, field_of_view: float = FIELD_OF_VIEW) -> Clip:
    """The photos of a folder in natural order (2.jpg before 10.jpg).

    Files that are no photos (`kinds_of`), and photos without a number beside numbered ones, are left
    out and reported. Raises ClipError when there is none, when two have one name but for the suffix, or
    when sizes differ.
    """
    visible = [entry for entry in path.iterdir() if is_visible(entry)]
    files = sorted((entry for entry in visible if entry.is_file()), key=natural_key)
    kinds = kinds_of(entry for entry in files if is_picture(entry) or is_named_array(entry))
    numbered = [entry for entry in kinds.photos if re.search(r"\d", entry.stem)]
    paths = tuple(numbered or kinds.photos)
    if not paths:
        folders = ", ".join(sorted(entry.name for entry in visible if entry.is_dir()))
        videos = [entry.name for entry in files if entry.suffix.lower() in VIDEOS]
        inside = f"folders {folders}" if folders else f"videos {listed(videos)}" if videos else ""
        hint = f"; it holds the {inside}: open one of these" if inside else ""
        raise ClipError(f"expected pictures in the folder, got none{hint}: {path}")
    _check_names(paths, path)
    told = {*paths, *kinds.others}
    strays = sorted(entry.name for entry in files if entry not in told)
    lost = sorted(entry.name for entry in visible if not entry.exists())
    said = (
        *((f"left out, no numbered pictures: {listed(strays)}",) if strays else ()),
        *((f"left out, links that lead nowhere: {listed(lost)}",) if lost else ()),
    )
    return _without_depth(
        path,
        "images",
        labels=tuple(entry.name for entry in paths),
        size=common_size(paths),
        read=lambda index: read_rgb(paths[index]),
        field_of_view=field_of_view,
        notices=(*kinds.notices(), *said),
    )


def _check_names(paths: tuple[Path, ...], folder: Path) -> None:
    """Raises ClipError for 1.jpg beside 1.png, which would be one moment twice."""
    first: dict[str, Path] = {}
    for path in paths:
        other = first.setdefault(path.stem, path)
        if other != path:
            both = f"{other.name} and {path.name}"
            raise ClipError(f"expected one picture a name, got {both}: move one kind elsewhere: {folder}")


def open_image(path: Path, field_of_view: float = FIELD_OF_VIEW) -> Clip:
    """One picture as a clip of one frame. Raises ClipError when it is none."""
    image = read_rgb(path)
    return _without_depth(
        path,
        "image",
        labels=(path.name,),
        size=(image.shape[1], image.shape[0]),
        read=lambda index: read_rgb((path,)[index]),
        field_of_view=field_of_view,
    )


def open_video(path: Path, field_of_view: float = FIELD_OF_VIEW) -> Clip:
    """A video file; any frame can be asked for, in any order and from any thread.

    The number of frames is what decodes, not what the header announces. Raises ClipError when
    the file is no video.
    """
    video = _Video(path)
    image = video.read(0)
    announced, count = video.announced, len(video)
    short = f"the file is cut off: it announces {announced} frames, {count} are whole"
    return _without_depth(
        path,
        "video",
        labels=tuple(str(index) for index in range(count)),
        size=(image.shape[1], image.shape[0]),
        read=video.read,
        field_of_view=field_of_view,
        frames_per_second=video.frames_per_second,
        notices=(short,) if announced > count else (),
    )


def _without_depth(
    path: Path,
    format: str,
    *,
    labels: tuple[str, ...],
    size: tuple[int, int],
    read: Callable[[int], ByteImage],
    field_of_view: float,
    frames_per_second: float | None = None,
    notices: tuple[str, ...] = (),
) -> Clip:
    camera = Camera.from_fov(field_of_view, *size)

    def read_frame(index: int) -> Frame:
        index = range(len(labels))[index]
        every = np.ones((size[1], size[0]), dtype=bool)
        return Frame(index, index / len(labels), read(index), camera, every, every)

    return Clip(
        name=path.resolve().stem if path.is_file() else path.resolve().name,
        path=path,
        format=format,
        cameras=(camera,) * len(labels),
        read_frame=read_frame,
        read_image=read,
        labels=labels,
        has_depth=False,
        unit="scene units",
        frames_per_second=frames_per_second,
        notices=notices,
    )


class _Video:
    """Frames by number from one decoder, used under a lock.

    Packet time stamps, sorted, tell which frame is which: a frame is returned only when its own
    stamp is the wanted one, so seeking that lands elsewhere is noticed and mended.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._capture = _open_capture(path)
        self.announced = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))
        rate = self._capture.get(cv2.CAP_PROP_FPS)
        self.frames_per_second = rate if 0 < rate < 1000 else None
        self._stamps = _packet_stamps(path)
        self._at = -1
        self._keep_decodable()

    def __len__(self) -> int:
        return len(self._stamps)

    def read(self, index: int) -> ByteImage:
        """(H, W, 3) RGB. Raises ClipError when the frame is damaged."""
        index = range(len(self))[index]
        with self._lock:
            for approach in (self._step, self._seek, self._restart):
                if approach(index) and self._grab_until(index):
                    ok, picture = self._capture.retrieve()
                    if ok:
                        return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)
        raise ClipError(f"frame {index} of {len(self)} cannot be decoded: {self._path}")

    def _step(self, index: int) -> bool:
        return 0 < index - self._at <= _STEP_LIMIT

    def _seek(self, index: int) -> bool:
        return self._capture.set(cv2.CAP_PROP_POS_FRAMES, index)

    def _restart(self, index: int) -> bool:
        self._capture = _open_capture(self._path)
        return True

    def _grab_until(self, index: int) -> bool:
        wanted = self._stamps[index]
        self._at = index
        while self._capture.grab():
            stamp = int(self._capture.get(cv2.CAP_PROP_PTS))
            if stamp >= wanted:
                return stamp == wanted
        return False

    def _keep_decodable(self) -> None:
        """Drops stamps that no decoded frame bears: before the first frame, and among the last."""
        if not self._capture.grab():
            raise ClipError(f"expected a video, got a file without a frame that decodes: {self._path}")
        first = int(self._capture.get(cv2.CAP_PROP_PTS))
        if first not in self._stamps:
            self._stamps = _decoded_stamps(_open_capture(self._path))
        self._stamps = [stamp for stamp in self._stamps if stamp >= first]
        start = max(0, len(self) - _TAIL)
        reached = self._seek(start) and self._grab_until(start)
        if not reached:
            self._restart(start)
            reached = self._grab_until(start)
        if reached:
            tail = [self._stamps[start], *_decoded_stamps(self._capture)]
            self._stamps = self._stamps[:start] + tail
        else:
            self._stamps = _decoded_stamps(_open_capture(self._path))
        if 1 < len(self) < self.announced:
            self._stamps.pop()  # Of a file that is cut off, the last packet decodes to a damaged picture.
        self._restart(0)
        self._at = -1


def _open_capture(path: Path) -> cv2.VideoCapture:
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        # The decoder would end the process.
        shown = str(path).encode(errors="backslashreplace").decode()
        raise ClipError(f"expected a path in UTF-8, rename or move it: {shown}") from error
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise ClipError(f"expected a picture or a video, got a file that is neither, or damaged: {path}")
    return capture


def _packet_stamps(path: Path) -> list[int]:
    """Presentation time stamps of all video packets in order; nothing is decoded."""
    capture = _open_capture(path)
    if not capture.set(cv2.CAP_PROP_FORMAT, -1):
        return []
    return _decoded_stamps(capture)


def _decoded_stamps(capture: cv2.VideoCapture) -> list[int]:
    stamps = set[int]()
    while capture.grab():
        stamps.add(int(capture.get(cv2.CAP_PROP_PTS)))
    return sorted(stamps)
