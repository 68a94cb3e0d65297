"""What a window that is opened on a live source is told of it."""

from __future__ import annotations

from dataclasses import dataclass

from app.live.address import LiveInput
from app.live.igtl.endpoint import Endpoint


@dataclass(frozen=True)
class LiveStart:
    """The source, and where other programs get its pictures; None: nowhere until a person asks for it."""

    source: LiveInput
    endpoint: Endpoint | None = None
