"""Records what is live, in a thread of its own: what is on the disk plays, whenever the process is killed."""

from __future__ import annotations

import logging
import os
import queue
import shutil
import threading
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np

from app.errors import UserError, sentence
from app.files.atomic import make_folder
from app.files.codecs import MP4
from app.files.legible import require_utf8
from app.files.provenance import plain, provenance, write_sidecar
from app.live.picture import RECORDING, LivePicture, LiveSetting
from app.live.segment import Segment
from app.live.sidecar import Sidecar
from renderer.clip import ByteImage
from renderer.readers.clip_options import StereoLayout

What = Literal["original", "enhanced", "side by side"]
WHATS: Final[tuple[What, ...]] = get_args(What)
WAITING: Final = 8
"""Pictures that may wait for the encoder; more are left out and counted."""
LEAST_FREE: Final = 64 * 1024 * 1024
"""Bytes that stay free on the disk: a full one would stop more than this recording."""
LOOK: Final = 0.05
"""Seconds after which it looks whether it was ended."""
LOOK_EVERY: Final = 32
"""Pictures from one look at the disk to the next."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Recording:
    """How far it is."""

    path: Path
    """Of the file that is written now, or was last."""
    what: What
    seconds: float = 0.0
    """From the first picture to the last."""
    pictures: int = 0
    left_out: int = 0
    """Pictures that the encoder had no time for."""
    files: int = 1
    """More than one where the size of the pictures has changed."""
    is_over: bool = False
    trouble: str = ""
    """Why it ended before it was told to."""


class Recorder:
    """Give it pictures by `add`, which never waits; end it by `finish`."""

    def __init__(self, path: Path, what: What, source: str) -> None:
        """Begin a new file, which nothing may be in the way of: see `require_new`.

        source: what is recorded, as a person calls it, for its provenance.
        """
        self._written = Recording(path, what)
        self._left_out = 0
        self._source = source
        self._first = path
        self._has_made_it = False  # What lies there already is not for it to take away.
        self._waiting: queue.Queue[LivePicture] = queue.Queue(WAITING)
        self._ending = threading.Event()
        self._segment: Segment | None = None
        self._stereo: StereoLayout | None = None
        self._start: float | None = None
        self._files: list[dict[str, Any]] = []
        self._settings: list[dict[str, Any]] = []
        self._setting: LiveSetting | None = None
        self._sidecar, self._is_unsaid = Sidecar(path), False
        self._thread = threading.Thread(target=self._run, name="vesselsplat-recorder", daemon=True)
        self._thread.start()

    @property
    def state(self) -> Recording:
        """What the encoder has written and what `add` left out: each is counted by a thread of its own."""
        return replace(self._written, left_out=self._left_out)

    def add(self, picture: LivePicture) -> None:
        """The next picture, in the order of arrival."""
        if self._written.is_over or self._ending.is_set():
            return
        try:
            self._waiting.put_nowait(picture)
        except queue.Full:
            self._left_out += 1

    def end(self) -> None:
        """Write what waits and end the file, without waiting for it: `state` tells when that is done."""
        self._ending.set()

    def finish(self, timeout: float = 10.0) -> Recording:
        """The same, and wait for it. A recording without a picture leaves no file."""
        self.end()
        self._thread.join(timeout)
        return self.state

    def _run(self) -> None:
        trouble = ""
        try:
            make_folder(self._first.parent)
            self._first.touch(exist_ok=False)
            self._has_made_it = True
            while (picture := self._next()) is not None:
                self._write(picture)
        except Exception as error:
            # Whatever it is, it is told, and the picture on the screen outlives it.
            log.info("a recording has ended early", exc_info=True)
            trouble = sentence(error)
        self._end(trouble)

    def _next(self) -> LivePicture | None:
        """None: it was ended, and nothing waits."""
        while True:
            if self._sidecar.has_time() and self._is_unsaid:
                self._is_unsaid = False
                self._sidecar.begin(self._facts() | self._course())
            try:
                return self._waiting.get(timeout=LOOK)
            except queue.Empty:
                if self._ending.is_set():
                    return None

    def _write(self, picture: LivePicture) -> None:
        if self._written.pictures % LOOK_EVERY == 0:
            free = shutil.disk_usage(self._written.path.parent).free
            if free < LEAST_FREE:
                raise UserError(f"the disk is nearly full: {free / 1e6:.0f} MB are free")
        image = shown(picture, self._written.what)
        if self._start is None:
            self._start = picture.arrived
        seconds = picture.arrived - self._start
        stereo, aspect = layout_shown(picture, self._written.what)
        shape = image.shape[1], image.shape[0], stereo, aspect
        begins = self._segment is None or self._segment.shape != shape
        if begins:
            self._begin(image, seconds, stereo, aspect)
        assert self._segment is not None
        self._segment.write(image, seconds)
        if begins:
            self._files.append({"name": self._written.path.name, "from_seconds": round(seconds, 3)})
        if begins or picture.setting != self._setting:
            self._note(picture.setting, seconds)
        self._written = replace(self._written, seconds=seconds, pictures=self._written.pictures + 1)

    def _begin(self, image: ByteImage, seconds: float, stereo: StereoLayout | None, aspect: float) -> None:
        """Another file where another shape goes on."""
        self._stereo = stereo
        if self._segment is not None:
            self._segment.finish()
            files = self._written.files + 1
            path = _numbered(self._first, files)
            self._written = replace(self._written, path=path, files=files)
        size = image.shape[1], image.shape[0]
        self._segment = Segment(self._written.path, size, seconds, self._facts(), stereo, aspect)

    def _note(self, setting: LiveSetting, seconds: float) -> None:
        """From here on pictures are enhanced otherwise, or in another file: said beside the first."""
        if setting != self._setting:
            self._setting = setting
            said = {"from_seconds": round(seconds, 3), "params": setting.params, "pixels": setting.pixels}
            self._settings.append(plain(said))
        self._is_unsaid = True

    def _facts(self) -> dict[str, Any]:
        facts = {"source": self._source, "what": self._written.what, "stereo": self._stereo}
        return provenance(kind=RECORDING, **facts)

    def _course(self) -> dict[str, Any]:
        """What changed when, in seconds from the first picture."""
        return {"files": list(self._files), "settings": list(self._settings)}

    def _end(self, trouble: str) -> None:
        for step in (self._finish_segment, self._take_away_empty, self._sidecar.close):
            try:
                step()
            except Exception as error:
                trouble = trouble or sentence(error)
        self._written = replace(self._written, is_over=True, trouble=trouble)
        if self._files:
            with suppress(OSError, UserError):
                done = plain({"recorded": _without_path(self.state)})
                write_sidecar(self._first, self._facts() | self._course() | done)

    def _finish_segment(self) -> None:
        if self._segment is not None:
            self._segment.finish()

    def _take_away_empty(self) -> None:
        """The file under way, where no picture came to be in it."""
        path, names = self._written.path, [one["name"] for one in self._files]
        if path.name not in names and self._has_made_it:
            path.unlink(missing_ok=True)
        if path.name not in names and names:
            self._written = replace(self._written, path=path.with_name(names[-1]), files=len(names))


def require_new(path: Path) -> None:
    """Raises UserError: it ends otherwise than in .mp4, is not UTF-8, or is there already."""
    if path.suffix.lower() != MP4:
        raise UserError(f"expected a recording to end in {MP4}, got {path.name}: {path}")
    require_utf8(path)
    if os.path.lexists(path):
        raise UserError(f"expected a new file to record into, got one that exists: {path}")


def shown(picture: LivePicture, what: What) -> ByteImage:
    """(H, W, 3), of an even size, as encoders need it: originals with both eyes as they came, others of the
    left one."""
    enhanced = picture.original if picture.enhanced is None else picture.enhanced
    if what == "original":
        image = picture.original if picture.pair is None else picture.pair.image
    elif what == "enhanced":
        image = enhanced
    else:
        image = np.concatenate((picture.original, enhanced), axis=1)
    height, width = image.shape[0] // 2 * 2, image.shape[1] // 2 * 2
    return np.ascontiguousarray(image[:height, :width])


def layout_shown(picture: LivePicture, what: What) -> tuple[StereoLayout | None, float]:
    """How both eyes lie in what is recorded (None: it is of one), and the width of a pixel by its height."""
    if what == "original" and picture.pair is not None:
        return picture.pair.layout, picture.pair.pixel_aspect
    return None, picture.pixel_aspect


def _without_path(done: Recording) -> dict[str, Any]:
    """What may be said of it: no folder of this computer."""
    return {name: value for name, value in vars(done).items() if name not in ("path", "is_over")}


def _numbered(path: Path, number: int) -> Path:
    """NAME-2.mp4, or the next that is free."""
    while (found := path.with_name(f"{path.stem}-{number}{path.suffix}")).exists():
        number += 1
    return found
