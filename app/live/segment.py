"""One video file that is written as it comes: fragments of half a second, each complete by itself."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import av

from app.files.codecs import BT709
from app.files.provenance import strict_json
from app.files.pyav_writing import MATRICES, TICKS, encodable, encoded
from renderer.clip import ByteImage
from renderer.readers.clip_options import StereoLayout

FRAGMENT: Final = 0.5
"""Seconds that a fragment lasts at most, and so what a kill may cost beside the picture in hand."""
# Without a look ahead: a picture that went in has come out.
X264: Final = "mbtree=0"
QUICK: Final = {"preset": "ultrafast", "tune": "zerolatency", "crf": "17", "x264-params": X264}
PACKING: Final[Mapping[StereoLayout, str]] = {
    "side-by-side": "frame-packing=3",
    "top-bottom": "frame-packing=4",
}
"""As H.264 numbers how both eyes lie in a frame."""
FRAGMENTED: Final = {
    "movflags": "frag_keyframe+empty_moov+default_base_moof",
    "flush_packets": "1",
}
MOST_ASPECT: Final = 1000
"""Up to which either number of the shape of a pixel goes; H.264 has 16 bits for each."""
RATE: Final = Fraction(30)
"""Of which nothing depends: each picture has its own time."""


class Segment:
    """Pictures of one size, each at its own time."""

    def __init__(
        self,
        path: Path,
        size: tuple[int, int],
        seconds: float,
        facts: dict[str, Any],
        stereo: StereoLayout | None = None,
        pixel_aspect: float = 1.0,
    ) -> None:
        """seconds: at which the first picture is taken; stereo: how both eyes lie in them, pixel_aspect:
        width of a pixel by its height, which the stream says itself. Raises OSError: it cannot be written."""
        self.shape = (*size, stereo, pixel_aspect)
        self._start = seconds
        self._container = av.open(f"file:{path.absolute()}", "w", container_options=FRAGMENTED)
        self._container.metadata["comment"] = strict_json(facts)
        options = QUICK if stereo is None else QUICK | {"x264-params": f"{X264}:{PACKING[stereo]}"}
        self._stream = self._container.add_stream("libx264", rate=RATE, options=options)
        self._stream.width, self._stream.height, self._stream.pix_fmt = *size, "yuv420p"
        codec = self._stream.codec_context
        codec.time_base = Fraction(1, TICKS)
        if pixel_aspect != 1:
            codec.sample_aspect_ratio = Fraction(pixel_aspect).limit_denominator(MOST_ASPECT)
        codec.color_primaries = codec.color_trc = codec.colorspace = BT709
        codec.color_range = 1
        self._last, self._key = -1, 0.0

    def write(self, image: ByteImage, seconds: float) -> None:
        """Raises OSError: the disk is full, or gone; UserError: H.264 cannot hold such pictures."""
        frame = encodable(image, MATRICES[BT709])
        passed = seconds - self._start
        self._last = frame.pts = max(round(passed * TICKS), self._last + 1)
        frame.time_base = Fraction(1, TICKS)
        if passed >= self._key:
            frame.pict_type = av.video.frame.PictureType.I
            self._key = passed + FRAGMENT
        with encoded("H.264", (image.shape[1], image.shape[0])):
            self._container.mux(self._stream.encode(frame))

    def finish(self) -> None:
        """Raises as `write`; the file is let go of in any case."""
        with encoded("H.264", self.shape[:2]):
            try:
                self._container.mux(self._stream.encode())
            finally:
                self._container.close()
