"""Frames of a video file by number, decoded by OpenCV: where PyAV is not installed, as in the bundle."""

from __future__ import annotations

import threading
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from renderer.clip import ByteImage, ClipError
from renderer.readers.cut_off import cut_off
from renderer.readers.dicom.opening import is_dicom
from renderer.readers.misnamed import neither
from renderer.readers.video_decoding.container_end import ends_early
from renderer.utf8_paths import not_utf8

STEP_LIMIT = 32
"""Frames that are cheaper to decode in passing than to seek over."""
MORE = "install PyAV to read more"
SAMPLES = 8
"""Frames that are compared with each other at opening."""
TAIL = 16
"""A video is cut off somewhere in its last packets: as many are decoded to know where."""


class OpenCvVideo:
    """Frames by number from one decoder, used under a lock.

    Packet time stamps, sorted, tell which frame is which: a frame is returned only when its own
    stamp is the wanted one, so seeking that lands elsewhere is noticed and mended.

    OpenCV converts colours by the matrix that the file names, and by BT.601 where it names none, HD or not,
    and does not tell which of the two it did.
    """

    pixel_aspect = 1.0
    stereo = None
    """OpenCV reports neither, whatever the file says."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._capture = open_capture(path)
        self.frames_per_second = rate_of(self._capture)
        packets = _stamps(_packets(path))
        self._stamps = sorted(set(packets))
        # OpenCV tells time in frames of the mean rate: where the rate varies, two may share a stamp.
        self._is_counted = len(self._stamps) < len(packets)
        self._at = -1
        if self._is_counted:
            self._stamps = list(range(len(_stamps(self._capture))))
            self._restart(0)
        else:
            self._keep_decodable()
        self._refuse_unwritten()
        self.frame_times = self._times()
        self.notices: tuple[str, ...] = ()
        if ends_early(path):
            # Of a file that is cut off, the last packet decodes to a damaged picture.
            self._stamps = self._stamps[:1] + self._stamps[1:-1]
            self.frame_times = self.frame_times[: len(self)]
            self.notices = (cut_off(len(self)),)

    def __len__(self) -> int:
        return len(self._stamps)

    def read(self, index: int) -> ByteImage:
        """(H, W, 3) RGB. Raises ClipError when the frame is damaged."""
        with self._lock:
            for approach in (self._step, self._seek, self._restart):
                if approach(index) and self._grab_until(index):
                    ok, picture = self._capture.retrieve()
                    if ok:
                        return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)
        raise ClipError(f"frame {index + 1} of {len(self)} cannot be decoded: {self._path}")

    def _step(self, index: int) -> bool:
        return 0 < index - self._at <= STEP_LIMIT

    def _seek(self, index: int) -> bool:
        # To the frame before, without whose stamp the last one may not be known.
        return not self._is_counted and self._capture.set(cv2.CAP_PROP_POS_FRAMES, max(0, index - 1))

    def _restart(self, index: int) -> bool:
        self._capture = open_capture(self._path)
        self._at = -1
        return True

    def _grab_until(self, index: int) -> bool:
        wanted, at = self._stamps[index], self._at
        self._at = index
        if self._is_counted:
            return all(self._capture.grab() for _ in range(index - at))
        before = None
        while self._capture.grab():
            stamp = int(self._capture.get(cv2.CAP_PROP_PTS))
            stamp += stamp == before
            before = stamp
            if stamp >= wanted:
                return stamp == wanted
        return False

    def _keep_decodable(self) -> None:
        """Drops stamps that no decoded frame bears: before the first frame, and among the last."""
        if not self._capture.grab():
            raise ClipError(f"expected a video, got no frame that OpenCV decodes ({MORE}): {self._path}")
        first = int(self._capture.get(cv2.CAP_PROP_PTS))
        if first not in self._stamps:
            self._stamps = _shown(_stamps(open_capture(self._path)))
        self._stamps = [stamp for stamp in self._stamps if stamp >= first]
        start = max(0, len(self) - TAIL)
        reached = self._seek(start) and self._grab_until(start)
        if not reached:
            self._restart(start)
            reached = self._grab_until(start)
        if reached:
            tail = [self._stamps[start], *_stamps(self._capture)]
            self._stamps = self._stamps[:start] + _shown(tail)
        else:
            self._stamps = _shown(_stamps(open_capture(self._path)))
        self._restart(0)
        self._at = -1

    def _times(self) -> tuple[float, ...]:
        """Seconds from the first frame."""
        if self._is_counted:
            capture, seconds = open_capture(self._path), list[float]()
            while capture.grab():
                seconds.append(capture.get(cv2.CAP_PROP_POS_MSEC) / 1000)
            if all(later > one for one, later in pairwise(seconds)):
                return tuple(second - seconds[0] for second in seconds)
        rate = self.frames_per_second or 25.0
        return tuple((stamp - self._stamps[0]) / rate for stamp in self._stamps)

    def _refuse_unwritten(self) -> None:
        """OpenCV reports success for interlaced frames that it has not converted: they are stray memory.

        It is the same memory each time, so frames from all over the video are equal bit for bit.

        Raises:
            ClipError: they are.
        """
        spread = sorted({number * (len(self) - 1) // (SAMPLES - 1) for number in range(SAMPLES)})
        frames = [self.read(number) for number in spread]
        if len(frames) > 1 and all(np.array_equal(frame, frames[0]) for frame in frames[1:]):
            raise ClipError(
                "expected a video whose frames differ, got the same frame throughout, as OpenCV reads "
                f"interlaced video; {MORE}, or deinterlace it first: {self._path}"
            )


def open_capture(path: Path) -> cv2.VideoCapture:
    if said := not_utf8(path):  # The decoder would end the process.
        raise ClipError(said)
    if is_dicom(path):
        raise ClipError(f"a DICOM video needs PyAV: pip install av ({path.name})")
    # Of its own, since a name with a colon would be taken for an address.
    capture = cv2.VideoCapture(str(path.absolute()), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise ClipError(neither(path))
    return capture


def rate_of(capture: cv2.VideoCapture) -> float | None:
    """Frames a second as the file says it, where that makes sense."""
    rate = capture.get(cv2.CAP_PROP_FPS)
    return rate if 0 < rate < 1000 else None


def _packets(path: Path) -> cv2.VideoCapture:
    """For their time stamps alone: nothing is decoded."""
    capture = open_capture(path)
    capture.set(cv2.CAP_PROP_FORMAT, -1)
    return capture


def _stamps(capture: cv2.VideoCapture) -> list[int]:
    """The time stamps of all frames or packets, in the order in which the capture gives them."""
    stamps = []
    while capture.grab():
        stamps.append(int(capture.get(cv2.CAP_PROP_PTS)))
    return stamps


def _shown(stamps: list[int]) -> list[int]:
    """Sorted, one for each frame.

    Where packets tell when they are decoded and not when they are shown, as in .avi, each frame bears the
    stamp of a later packet, and the last frame, behind which none comes, that of the frame before it.
    """
    last = [stamps[-1] + 1] if stamps[-2:-1] == stamps[-1:] else []
    return sorted({*stamps, *last})
