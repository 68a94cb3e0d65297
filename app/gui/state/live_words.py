"""What the pictures of a live source say of themselves, so that no old picture looks live."""

from __future__ import annotations

from typing import Final

from app.gui.state.live import Live
from app.gui.state.tags import Tag
from app.gui.views.clip_time import clock
from app.live.picture import LiveStatus, Signal

HEADS: Final[dict[Signal, str]] = {
    "connecting": "CONNECTING",
    "live": "LIVE",
    "black": "BLACK FRAMES",
    "stale": "STALE",
    "lost": "SIGNAL LOST",
    "ended": "ENDED",
    "failed": "FAILED",
}


def live_tags(live: Live) -> tuple[Tag, ...]:
    """Loud wherever the picture is not of this moment; none where nothing is live."""
    status = live.status
    if live.session is None or status is None:
        return ()
    tags = [Tag("FROZEN · the source goes on", "caution")] if live.still is not None else []
    if not status.is_live:
        tags.append(Tag(not_live(status), "caution"))
    elif live.still is None:
        tags.append(Tag(f"LIVE · {pace(status)}"))
    if (recording := live.recording) is not None:
        tags.append(Tag(f"RECORDING · {clock(recording.seconds)}", "caution"))
    if (sending := live.sending) is not None and not live.endpoint.is_local:
        tags.append(Tag(str(sending).upper(), "caution"))
    return tuple(tags)


def is_not_live(live: Live) -> bool:
    """There is a live source, and the picture on screen is not of this moment."""
    if live.session is None or live.status is None:
        return False
    return live.still is not None or not live.status.is_live


def not_live(status: LiveStatus) -> str:
    """Why, and that what is seen is the last picture, if there ever was one."""
    never = status.arrived == 0
    parts = ["NO SIGNAL" if never and status.signal == "lost" else HEADS[status.signal], status.reason]
    if not never and status.signal not in ("black", "connecting"):
        parts.append("last frame shown")
    return " · ".join(filter(None, parts))


def pace(status: LiveStatus) -> str:
    """Rate and delay, as far as they are known."""
    delay = status.to_screen or status.to_ready
    rate = f"{status.frames_per_second:.0f} frames/s"
    return rate if delay is None else f"{rate} · {delay.median:.0f} ms"


def counts(live: Live, status: LiveStatus) -> str:
    """What came, what was left out, and to whom it is sent."""
    parts = [status.told, f"{status.arrived} frames, {status.dropped} dropped"]
    if status.apart is not None:
        parts.append(f"eyes {status.apart.median:.0f} ms apart, {status.unpaired} unpaired")
    if (sending := live.sending) is not None:
        parts.append(str(sending))
    return "   ·   ".join(parts)


def delay_text(status: LiveStatus) -> str:
    """All that is measured, for a tooltip."""
    lines = [f"The source delivers {status.told}."]
    for name, delay in (("enhanced", status.to_ready), ("on screen", status.to_screen)):
        if delay is not None:
            lines.append(f"From arrival to {name}: {delay} (last {delay.frames} frames).")
    if status.apart is not None:
        lines.append(
            f"From eye to eye: {status.apart}; {status.unpaired} pairs more than half a frame apart left out."
        )
    lines.append(f"{status.arrived} frames arrived, {status.dropped} were late and left out.")
    lines.append("The delays of camera, capture card and screen are not included.")
    return "\n".join(lines)
