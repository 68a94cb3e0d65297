"""A stream over the loopback address, sent by PyAV as a camera would."""

from __future__ import annotations

import socket
import threading
import time
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from app.errors import UserError
from app.live.sources.source import SourceLost
from app.live.sources.stream import StreamSource, rgb
from renderer.sources import open_clip
from tests.app.live.painted import painted
from tests.ports import free_port
from tests.renderer.readers.numbered import encoded, turned

LEVELS = (60, 120, 180)
ASPECT = Fraction(64, 45)
"""Of pixels, as of a standard-definition camera with a wide picture."""


class Camera:
    """Sends one grey level after another, half a second each, until it is unplugged."""

    def __init__(self, port: int) -> None:
        self._address = f"udp://127.0.0.1:{port}?pkt_size=1316"
        self._unplugged = threading.Event()
        self._thread = threading.Thread(target=self._send, daemon=True)
        self._thread.start()

    def unplug(self) -> None:
        self._unplugged.set()
        self._thread.join()

    def _send(self) -> None:
        options = {"preset": "ultrafast", "tune": "zerolatency"}
        with av.open(self._address, "w", format="mpegts") as container:
            stream = container.add_stream("libx264", rate=25, options=options)
            stream.width, stream.height, stream.pix_fmt, stream.gop_size = 128, 96, "yuv420p", 5
            stream.codec_context.sample_aspect_ratio = ASPECT
            number = 0
            while not self._unplugged.wait(0.04):
                image = painted(LEVELS[number // 12 % len(LEVELS)], (96, 128))
                frame = av.VideoFrame.from_ndarray(image, "rgb24")
                frame.pts, frame.time_base = number, Fraction(1, 25)
                container.mux(stream.encode(frame))
                number += 1


def test_frames_come_as_they_are_sent_and_silence_is_a_loss() -> None:
    port = free_port(socket.SOCK_DGRAM)
    camera = Camera(port)
    source = StreamSource(f"udp://127.0.0.1:{port}", "camera")
    start, levels = time.perf_counter(), set[int]()
    while time.perf_counter() - start < 2.5 and len(levels) < len(LEVELS):
        arrived = source.read()
        assert arrived is not None
        assert arrived.at >= start
        assert arrived.pixel_aspect == pytest.approx(float(ASPECT))
        level = int(np.median(arrived.read()[:40, :, 0]))
        levels.add(min(LEVELS, key=lambda one: abs(one - level)))
        assert min(abs(one - level) for one in LEVELS) < 6
    assert levels == set(LEVELS)
    assert source.told.startswith("128 × 96, 25 frames/s, h264")
    camera.unplug()
    began = time.perf_counter()
    with pytest.raises(SourceLost, match="no data in time"):
        all(iter(source.read, None))
    assert 1.5 < time.perf_counter() - began < 4
    source.close()


def test_a_turned_frame_stands_as_in_its_file(tmp_path: Path) -> None:
    image = painted(120, (96, 128))
    image[:32, :32] = 220
    path = turned(encoded(tmp_path / "turned.mp4", [image] * 3))
    with av.open(str(path)) as container:
        found = rgb(next(container.decode(video=0)))
    expected = open_clip(path).read_image(0)
    assert found.shape == expected.shape == (128, 96, 3)
    assert np.abs(found.astype(int) - expected).mean() <= 1.5


def test_what_does_not_answer_says_so_without_its_address() -> None:
    port = free_port(socket.SOCK_DGRAM)
    with pytest.raises(SourceLost, match=r"nothing can be received from a camera \(connection refused\)"):
        StreamSource(f"rtsp://user:word@127.0.0.1:{port}/x", "a camera")


def test_a_kind_of_stream_that_cannot_be_received_is_refused() -> None:
    with pytest.raises(UserError, match="which srt is not"):
        StreamSource("srt://127.0.0.1:9", "a camera")
