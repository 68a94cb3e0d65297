"""A live source as the command line names it: its eyes, and where its frames are sent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from app.live.address import Device, LiveInput, address_of, input_of
from app.live.igtl.endpoint import Endpoint, endpoint_of
from renderer.readers.clip_options import Stereo


@dataclass(frozen=True)
class LiveStart:
    """The source, and where other programs get its pictures; None: nowhere until a person asks for it."""

    source: LiveInput
    endpoint: Endpoint | None = None


def start_of(
    source: str, right: str | None, stereo: Stereo, igtl: str | None, devices: Sequence[Device]
) -> LiveStart:
    """What is meant by SOURCE, --right, --stereo and --igtl. Raises UserError: one of them means nothing."""
    meant = input_of(address_of(source, devices), right, stereo, devices)
    return LiveStart(meant, None if igtl is None else endpoint_of(igtl))
