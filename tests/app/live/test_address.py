"""What a person may name as a live source."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.errors import UserError
from app.live.address import Device, LiveAddress, address_of

CARD = Device("0", "HDMI grabber")


@pytest.mark.parametrize("said", ["0", "HDMI grabber", " 0 "])
def test_a_device_is_known_by_number_and_name(said: str) -> None:
    assert address_of(said, (CARD,)) == LiveAddress("device", "0", "HDMI grabber")


def test_a_number_that_is_not_listed_is_still_a_device() -> None:
    assert address_of("3") == LiveAddress("device", "3", "device 3")


def test_a_stream_is_named_without_what_may_be_secret() -> None:
    found = address_of("rtsp://ward:pass@10.0.0.7:554/key/one?token=x")
    assert found.kind == "stream"
    assert found.where == "rtsp://ward:pass@10.0.0.7:554/key/one?token=x"
    assert found.name == "rtsp://10.0.0.7:554"


def test_a_file_is_named_without_its_folder(tmp_path: Path) -> None:
    file = tmp_path / "case.mp4"
    file.touch()
    assert address_of(str(file)) == LiveAddress("file", str(file), "case.mp4")


@pytest.mark.parametrize("said", ["", "nosuch.mp4", "ftp://host/x", "grabber"])
def test_anything_else_is_refused_in_a_line(said: str) -> None:
    with pytest.raises(UserError) as told:
        address_of(said, (CARD,))
    assert "\n" not in str(told.value)
    assert "HDMI grabber" in str(told.value) or "expected a stream by" in str(told.value)


def test_a_host_that_is_none_is_refused_without_what_may_be_secret() -> None:
    with pytest.raises(UserError, match="expected a stream such as rtsp://HOST/PATH") as told:
        address_of("rtsp://ward:pass@[::1/key")
    assert "pass" not in str(told.value)
