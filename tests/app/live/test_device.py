"""A capture device is asked for a format, a size and a rate, and what it really gives is told."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.gui.work.live_devices import DevicesRequest, find_devices
from app.live.address import Device, address_of, input_of
from app.live.sources import device
from app.live.sources.device import DeviceSource, ask_permission, devices, devices_for
from app.live.sources.source import SourceLost, Wish

BLUE = np.zeros((4, 6, 3), np.uint8) + np.array([200, 0, 10], np.uint8)


class FakeCapture:
    """As cv2.VideoCapture: a card that gives 720p whatever it is asked for."""

    def __init__(self, where: int | str, frames: int = 3, *, opens: bool = True) -> None:
        self.where, self.left, self.opens, self.asked, self.released = where, frames, opens, {}, False
        self.facts = {
            cv2.CAP_PROP_FRAME_WIDTH: 1280.0, cv2.CAP_PROP_FRAME_HEIGHT: 720.0, cv2.CAP_PROP_FPS: 59.94,
            cv2.CAP_PROP_FOURCC: float(cv2.VideoWriter.fourcc(*"MJPG")),
        }  # fmt: skip

    def isOpened(self) -> bool:
        return self.opens

    def set(self, name: int, value: float) -> bool:
        self.asked[name] = value
        return False

    def get(self, name: int) -> float:
        return self.facts[name]

    def grab(self) -> bool:
        self.left -= 1
        return self.left >= 0

    def retrieve(self) -> tuple[bool, Any]:
        return True, BLUE

    def release(self) -> None:
        self.released = True


def test_it_is_asked_format_first_and_tells_what_it_gives() -> None:
    made = list[FakeCapture]()

    def opened(where: int | str) -> Any:
        made.append(FakeCapture(where))
        return made[-1]

    wish = Wish((1920, 1080), 30.0, "mjpg")
    source = DeviceSource("2", "card", wish, opened)
    assert made[0].where == 2
    assert list(made[0].asked)[:4] == [
        cv2.CAP_PROP_FOURCC, cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FPS
    ]  # fmt: skip
    assert made[0].asked[cv2.CAP_PROP_FOURCC] == cv2.VideoWriter.fourcc(*"MJPG")
    assert source.told == "1280 × 720, 59.9 frames/s, MJPG"
    arrived = source.read()
    assert arrived is not None
    assert arrived.read()[0, 0].tolist() == [10, 0, 200]
    source.close()
    assert made[0].released


def test_one_that_is_taken_or_unplugged_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SourceLost, match="another program"):
        DeviceSource("0", "card", Wish(), lambda where: FakeCapture(where, opens=False))  # type: ignore[return-value]
    monkeypatch.setattr(sys, "platform", "darwin")
    with pytest.raises(SourceLost, match="not allowed in System Settings"):
        DeviceSource("0", "card", Wish(), lambda where: FakeCapture(where, opens=False))  # type: ignore[return-value]
    source = DeviceSource("0", "card", Wish(), lambda where: FakeCapture(where, frames=1))  # type: ignore[return-value]
    source.read()
    with pytest.raises(SourceLost, match="no more frames"):
        source.read()


@pytest.mark.skipif(not Path("/sys/class").is_dir(), reason="lists devices as Linux does")
def test_devices_are_listed_by_name_without_their_other_nodes(tmp_path: Path) -> None:
    nodes = (("video0", "0", "HDMI card"), ("video1", "1", "HDMI card"), ("video10", "0", "Cam"))
    for node, index, name in (*nodes, ("video2", "0", "UVC")):
        (tmp_path / node).mkdir()
        (tmp_path / node / "index").write_text(index)
        (tmp_path / node / "name").write_text(f"{name}\n")
    assert devices(tmp_path) == (Device("0", "HDMI card"), Device("2", "UVC"), Device("10", "Cam"))
    assert devices(tmp_path / "none") == ()


def test_the_dialog_lists_at_once_and_previews_those_that_can_be_read() -> None:
    good, bad = Device("0", "good"), Device("1", "bad")

    def opened(one: Device) -> DeviceSource:
        return DeviceSource(one.where, one.name, Wish(), lambda where: FakeCapture(where, opens=where == 0))  # type: ignore[return-value]

    first, second = find_devices(DevicesRequest(1), lambda: (good, bad), opened)
    assert first.devices == second.devices == (good, bad)
    assert not first.previews
    assert list(second.previews) == ["0"]
    assert second.previews["0"].shape == (160, 240, 3)


def test_cameras_are_opened_only_where_a_name_may_mean_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = list[int | str]()

    def opened(where: int | str) -> Any:
        tried.append(where)
        return FakeCapture(where, opens=where == 1)

    monkeypatch.setattr(device, "opened", opened)
    monkeypatch.setattr(device.devices, "__defaults__", (device.LISTED, opened))
    monkeypatch.setattr(sys, "platform", "darwin")
    said = (str(tmp_path), "rtsp://host/path", "0", None)
    assert [devices_for(one, None) for one in said] == [()] * 4
    assert devices_for("0", str(tmp_path)) == ()
    assert tried == []
    assert devices_for("device 1", None) == (Device("1", "device 1"),)
    assert tried == list(range(6))
    tried.clear()
    ask_permission(input_of(address_of("rtsp://host/path"), None, "auto"))
    assert tried == []
    ask_permission(input_of(address_of("rtsp://host/path"), "3", "auto"))
    assert tried == [3]
    monkeypatch.setattr(sys, "platform", "linux")
    ask_permission(input_of(address_of("3"), None, "auto"))
    assert tried == [3]
