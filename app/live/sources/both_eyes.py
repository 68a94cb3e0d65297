"""A source whose frames hold both eyes, side by side or one above the other."""

from __future__ import annotations

from dataclasses import replace

from app.live.sources.source import Arrived, Source
from renderer.readers.clip_options import StereoLayout
from renderer.readers.video_decoding.stereo_layout import eye_size, squeezed


class BothEyesSource:
    """Tells how the eyes lie in each frame; the first is looked at, so that what cannot be halved is refused
    before it is shown."""

    def __init__(self, source: Source, layout: StereoLayout) -> None:
        self._source, self._layout = source, layout
        self._squeezed = ""
        self._is_known = False

    @property
    def told(self) -> str:
        return f"{self._source.told}, {self._layout} stereo{self._squeezed}"

    @property
    def frames_per_second(self) -> float | None:
        return self._source.frames_per_second

    def read(self) -> Arrived | None:
        """Raises ClipError: the first frame cannot be split into two eyes; SourceLost as any."""
        arrived = self._source.read()
        if arrived is None:
            return None
        if not self._is_known:
            image = arrived.read()
            eye = eye_size((image.shape[1], image.shape[0]), self._layout)
            self._squeezed, self._is_known = squeezed(eye, self._layout, arrived.pixel_aspect), True
            arrived = replace(arrived, read=lambda: image)
        return replace(arrived, stereo=self._layout)

    def close(self) -> None:
        self._source.close()
