"""Live pictures by OpenIGTLink: bit for bit to a real client; one that never reads holds up nobody."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import numpy as np
import psutil
import pytest
from pyigtl import OpenIGTLinkClient

from app.errors import UserError
from app.live.igtl.checksum import POLYNOMIAL, crc64
from app.live.igtl.endpoint import Endpoint, endpoint_of
from app.live.igtl.sender import Sender
from app.live.picture import LivePicture, LiveSetting
from app.live.session import LiveSession
from assets import phantom_path
from tests.app.conftest import Cli
from tests.app.live.painted import PaintedSource, painted, wait_for
from tests.ports import free_port

PLAIN = LiveSetting(None)


def free() -> Endpoint:
    return Endpoint(port=free_port())


@contextmanager
def sending() -> Iterator[Sender]:
    sender = Sender(free())
    try:
        yield sender
    finally:
        assert not sender.finish().trouble
        assert sender.state.is_over


@contextmanager
def client_of(endpoint: Endpoint) -> Iterator[OpenIGTLinkClient]:
    client = OpenIGTLinkClient(endpoint.host, endpoint.port)
    try:
        yield client
    finally:
        client.stop()


@pytest.mark.parametrize("size", [0, 1, 7, 8, 9, 1000])
def test_the_checksum_is_that_of_dividing_bit_by_bit(size: int) -> None:
    data = np.random.default_rng(size).integers(0, 256, size, np.uint8)
    rest = 0
    for byte in data.tolist():
        rest ^= byte << 56
        for _ in range(8):
            rest = (rest << 1) ^ ((1 << 64 | int(POLYNOMIAL)) if rest >> 63 else 0)
    assert crc64(data) == rest


@pytest.mark.parametrize("aspect", [1.0, 1.5])
def test_a_client_gets_the_enhanced_picture_bit_for_bit_with_its_time_and_axes(aspect: float) -> None:
    enhanced = np.random.default_rng(0).integers(0, 256, (48, 64, 3), np.uint8)
    now, arrived = time.time(), time.perf_counter()
    picture = LivePicture(1, arrived, painted(9), enhanced, PLAIN, None, (), 0.0, pixel_aspect=aspect)
    with sending() as sender:
        with client_of(sender.endpoint) as client:
            wait_for(lambda: sender.state.clients == 1, "the client")
            sender.add(picture)
            got = client.wait_for_message("VesselSplat", 10)
            wait_for(lambda: sender.state.sent == 1, "the count")
        wait_for(lambda: sender.state.clients == 0, "the end of the client")
        assert str(sender.state) == f"sending to 127.0.0.1:{sender.endpoint.port}, 0 clients"
    assert got.message_type == "IMAGE"
    assert np.array_equal(got.image, enhanced[np.newaxis])
    assert abs(got.timestamp - now) < 0.02
    # Columns go to the left of the patient, rows to the back, from the first pixel at the origin.
    assert got.world_coordinate_system == "ras"
    assert np.allclose(got.ijk_to_world_matrix, np.diag((-aspect, -1, 1, 1)), atol=1e-4)


def test_a_client_that_never_reads_holds_up_neither_the_picture_nor_another_client() -> None:
    frames, memory = 120, psutil.Process().memory_info
    with sending() as sender, socket.create_connection(("127.0.0.1", sender.endpoint.port)) as stuck:
        wait_for(lambda: sender.state.clients == 1, "the client that never reads")
        with client_of(sender.endpoint) as client:
            wait_for(lambda: sender.state.clients == 2, "the client that reads")
            source = PaintedSource(range(1, 1 + frames), pause=0.04, size=(720, 1280))
            session = LiveSession(lambda: source, PLAIN, recipients=(sender.add,))
            wait_for(lambda: session.status().made >= 40, "the first pictures")
            before = memory().rss
            wait_for(lambda: session.is_over, "the end")
            assert memory().rss - before < 40e6  # A picture is 2.8 MB; 80 of them came.
            status = session.status()
            session.close()
            assert status.made >= 0.9 * frames
            levels = list[int]()
            wait_for(lambda: _newest(client, levels) == frames, "the newest picture")
        stuck.close()
        wait_for(lambda: sender.state.clients == 0, "the ends of both")
        assert sender.state.left_out > 0.8 * frames


def _newest(client: OpenIGTLinkClient, levels: list[int]) -> int:
    levels += [int(one.image[0, 0, 0, 0]) for one in client.get_latest_messages()]
    return levels[-1] if levels else 0


def listens(endpoint: Endpoint) -> bool:
    with suppress(OSError), socket.create_connection((endpoint.host, endpoint.port)):
        return True
    return False


def test_a_command_sends_and_counts(vesselsplat: Cli) -> None:
    endpoint, seen = free(), list[tuple[int, ...]]()

    def fetch() -> None:
        wait_for(lambda: listens(endpoint), "the command", 300)
        with client_of(endpoint) as client:
            seen.append(client.wait_for_message("VesselSplat", 10).image.shape)

    fetching = threading.Thread(target=fetch)
    fetching.start()
    done = vesselsplat("live", phantom_path(), "--seconds", "2", "--igtl", str(endpoint.port), "--json")
    fetching.join()
    assert done.code == 0
    assert "frames leave" not in done.error
    told = json.loads(done.out)["sending"]
    assert told["address"] == str(endpoint)
    assert told["sent"] > 0
    assert seen[0][0] == 1
    assert seen[0][3] == 3


@pytest.mark.parametrize(
    ("said", "meant", "is_local"),
    [
        ("18944", "127.0.0.1:18944", True),
        ("localhost:1", "127.0.0.1:1", True),
        ("0.0.0.0:7", "0.0.0.0:7", False),
        ("[::1]:7", "[::1]:7", True),
    ],
)
def test_only_a_named_address_is_reached_from_outside(said: str, meant: str, is_local: bool) -> None:
    endpoint = endpoint_of(said)
    assert (str(endpoint), endpoint.is_local) == (meant, is_local)
    assert ("may show a patient" in endpoint.warning) is not is_local


@pytest.mark.parametrize(
    "said", ["", ":18944", "clip.mp4", "0", "65536", "127.0.0.1:", "example.org:7", "9" * 5000]
)
def test_what_is_no_address_is_said_and_nothing_is_looked_up(said: str) -> None:
    with pytest.raises(UserError, match="expected PORT or HOST:PORT"):
        endpoint_of(said)


def test_mistakes_are_one_line(vesselsplat: Cli) -> None:
    with sending() as taken:
        done = vesselsplat("live", phantom_path(), "--igtl", str(taken.endpoint))
    assert (done.code, done.error.count("\n")) == (2, 1)
    assert f"cannot send at {taken.endpoint}: " in done.error
    foreign = vesselsplat("live", phantom_path(), "--igtl", "192.0.2.1:18944")
    assert foreign.code == 2
    assert "frames leave this computer" in foreign.error
