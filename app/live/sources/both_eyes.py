"""A source whose frames hold both eyes, side by side or one above the other."""

from __future__ import annotations

from dataclasses import replace

from app.live.sources.source import Arrived, Source
from renderer.readers.clip_options import StereoLayout
from renderer.readers.stereo_layout import eye_size, squeezed


class BothEyesSource:
    """Tells how the eyes lie in each frame; the first is looked at, so that what cannot be halved is refused
    before it is shown."""

    def __init__(self, source: Source, layout: StereoLayout) -> None:
        self._source, self._layout = source, layout
        self._eye: tuple[int, int] | None = None

    @property
    def told(self) -> str:
        shape = "" if self._eye is None else squeezed(self._eye, self._layout)
        return f"{self._source.told}, {self._layout} stereo{shape}"

    @property
    def frames_per_second(self) -> float | None:
        return self._source.frames_per_second

    def read(self) -> Arrived | None:
        """Raises ClipError: the first frame cannot be split into two eyes; SourceLost as any."""
        arrived = self._source.read()
        if arrived is None:
            return None
        if self._eye is None:
            image = arrived.read()
            self._eye = eye_size((image.shape[1], image.shape[0]), self._layout)
            arrived = replace(arrived, read=lambda: image)
        return replace(arrived, stereo=self._layout)

    def close(self) -> None:
        self._source.close()
