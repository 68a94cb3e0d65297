"""What a reconstruction will leave out, once all frames have been read for it."""

from __future__ import annotations

from app.gui.work.omissions import Omissions, OmissionsRequest, find_omissions


def found_omissions(request: OmissionsRequest) -> Omissions:
    *_, last = find_omissions(request)
    assert isinstance(last, Omissions)
    return last
