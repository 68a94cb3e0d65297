"""`vesselsplat live SOURCE`: a capture device, a stream or a file as if live, enhanced without a window."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final

from app.commands.method_flags import add_settings, params_of
from app.console.ending import ended_by_ctrl_c
from app.console.flags import add_fields, parameters, refuse
from app.console.progress import Report, progress
from app.enhancement.methods import PAPER, VESSEL
from app.enhancement.settable import PIXELS
from app.errors import UserError
from app.files.provenance import provenance, strict_json
from app.live.address import Kind, LiveInput
from app.live.igtl.endpoint import PORT, Endpoint
from app.live.igtl.sender import Sender, Sending
from app.live.picture import LiveSetting, LiveStatus
from app.live.recorder import WHATS, Recorder, Recording, require_new
from app.live.session import LiveSession, load
from app.live.sources.device import ask_permission, devices, devices_for, require_device
from app.live.sources.opening import open_input
from app.live.sources.source import Wish
from app.live.start import start_of
from renderer.readers.clip_options import ClipOptions

LOOK: Final = 0.05
"""Seconds from one look at the session to the next."""
PATIENCE: Final = 10.0
"""Seconds without any picture after which a source that never gave one is given up."""
HEEDED: Final[Mapping[str, frozenset[Kind]]] = {
    "once": frozenset({"file"}),
    "size": frozenset({"device"}),
    "fps": frozenset({"device", "file"}),
    "pixel_format": frozenset({"device"}),
}
"""Flags that not every kind of source heeds."""
NOT_GIVEN: Final[Mapping[str, object]] = {
    "right": None,
    "seconds": None,
    "record": None,
    "what": None,
    "igtl": None,
    "once": False,
    "size": None,
    "fps": None,
    "pixel_format": None,
}
"""Flags of a source, where they are not given."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "source",
        metavar="SOURCE",
        nargs="?",
        help="number or name of a capture device, address of a stream (rtsp://HOST/PATH, udp://@:PORT, "
        "http://...), or a file or folder that is played as if live",
    )
    add_fields(parser, ClipOptions, ("stereo",))
    parser.add_argument(
        "--right",
        metavar="SOURCE",
        help="source of the right eye, where SOURCE is the left one alone: frames that arrive within half a "
        "frame of each other are a pair",
    )
    parser.add_argument("--list", action="store_true", help="list the capture devices of this machine")
    parser.add_argument("--seconds", type=float, metavar="N", help="stop after N seconds (default: Ctrl+C)")
    parser.add_argument(
        "--record", type=Path, metavar="FILE.mp4", help="record the live source into a new file"
    )
    parser.add_argument("--what", choices=WHATS, help=f"what to record (default {WHATS[0]})")
    parser.add_argument(
        "--igtl",
        metavar="PORT|HOST:PORT",
        nargs="?",
        const=str(PORT),
        help="send the enhanced frames to 3D Slicer, as OpenIGTLink images (default port "
        f"{PORT}); only to programs of this computer unless HOST is another address of it",
    )
    parser.add_argument("--once", action="store_true", help="play a file to its end, not in a loop")
    parser.add_argument(
        "--size", nargs=2, type=int, metavar=("W", "H"), help="size in pixels to ask a device for"
    )
    parser.add_argument(
        "--fps", type=float, metavar="F", help="frames a second to ask a device for, or to play a file at"
    )
    parser.add_argument("--pixel-format", metavar="FOUR", help="format to ask a device for: MJPG, YUYV")
    parser.add_argument(
        "--method", choices=(PAPER, VESSEL), default=PAPER, help="as in `vesselsplat enhance`"
    )
    add_settings(parser, "and --strength, --d-factor")
    parser.add_argument("--pixels", choices=PIXELS[:2], default=PIXELS[0], help="as in `vesselsplat enhance`")
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    if flags.list:
        refuse(flags, NOT_GIVEN, "--list")
        _list(flags.json, [vars(one) for one in devices()])
        return
    if flags.source is None:
        raise UserError("expected a SOURCE: a device, the address of a stream, a file or a folder")
    reading = parameters(ClipOptions, flags)
    known = devices_for(flags.source, flags.right)
    start = start_of(flags.source, flags.right, reading.stereo, flags.igtl, known)
    asked, wish, setting = start.source, wish_of(flags), setting_of(flags)
    _check_effect(flags, asked)
    for one in asked.addresses:
        if one.kind == "device":
            require_device(one.where)
    if flags.record is not None:
        require_new(flags.record)
    # Compiling may take a minute, in which no source is to wait.
    load(setting)
    ask_permission(asked)
    sender = None if start.endpoint is None else _sender(start.endpoint)
    recorder = None if flags.record is None else Recorder(flags.record, flags.what or WHATS[0], asked.name)
    recipients = tuple(one.add for one in (recorder, sender) if one is not None)
    began = time.perf_counter()
    session = LiveSession(partial(open_input, asked, wish), setting, recipients=recipients)
    try:
        with progress(f"live from {asked.name}", 0, every=2.0) as report, ended_by_ctrl_c() as is_ended:
            _follow(session, recorder, sender, flags.seconds, is_ended, report)
    finally:
        session.close()
        recording = None if recorder is None else recorder.finish()
        sending = None if sender is None else sender.finish()
    last = session.status()
    if last.made == 0:
        if is_ended():
            raise KeyboardInterrupt
        raise UserError(f"no frame came from {asked.name}: {last.reason or 'none in that time'}")
    facts = _facts(last, time.perf_counter() - began) | {"source": asked.name, "setting": setting}
    _say(facts, last, recording, sending, flags.json)
    if recording is not None and recording.trouble:
        raise UserError(f"the recording ended early ({recording.trouble}): {recording.path}")
    if sending is not None and sending.trouble:
        raise UserError(f"sending ended early ({sending.trouble}): {sending.address}")


def wish_of(flags: argparse.Namespace) -> Wish:
    """What the source is asked for. Raises UserError: what no source could give."""
    if flags.seconds is not None and not flags.seconds > 0:
        raise UserError(f"--seconds: expected more than 0, got {flags.seconds:g}")
    if flags.fps is not None and not 0 < flags.fps < 1000:
        raise UserError(f"--fps: expected more than 0 and less than 1000, got {flags.fps:g}")
    if flags.size is not None and min(flags.size) < 1:
        raise UserError(f"--size: expected two numbers from 1 on, got {flags.size[0]} {flags.size[1]}")
    four = flags.pixel_format
    if four is not None and not (len(four) == 4 and four.isascii() and four.isprintable()):
        raise UserError(f"--pixel-format: expected four characters, such as MJPG, got {four}")
    size = None if flags.size is None else (flags.size[0], flags.size[1])
    return Wish(size, flags.fps, four, not flags.once)


def _check_effect(flags: argparse.Namespace, asked: LiveInput) -> None:
    """Raises UserError: a flag that the source, or what is asked for, does not heed."""
    if flags.what is not None and flags.record is None:
        raise UserError("--what: expected --record FILE.mp4 with it")
    kinds = {one.kind for one in asked.addresses}
    for name, heeding in HEEDED.items():
        if getattr(flags, name) not in (None, False) and not kinds & heeding:
            wanted = " or ".join(sorted(heeding))
            flag = name.replace("_", "-")
            raise UserError(f"--{flag}: expected a {wanted} as SOURCE, to which it applies, got {asked.name}")


def setting_of(flags: argparse.Namespace) -> LiveSetting:
    params = params_of(flags)
    assert params is not None
    return LiveSetting(params, flags.pixels)


def _sender(endpoint: Endpoint) -> Sender:
    """Raises UserError: nobody can connect at that place."""
    if endpoint.warning:
        sys.stderr.write(f"live: {endpoint.warning}\n")
    return Sender(endpoint)


def _follow(
    session: LiveSession,
    recorder: Recorder | None,
    sender: Sender | None,
    seconds: float | None,
    is_ended: Callable[[], bool],
    report: Report,
) -> None:
    """Until it is ended, the time is over, the source has ended, or it never came.

    Raises UserError: it cannot come.
    """
    began, is_awaited, trouble = time.perf_counter(), False, ""
    while not session.is_over and not is_ended():
        time.sleep(LOOK)
        now, passed = session.status(), time.perf_counter() - began
        if now.arrived:
            report(now.made, line_of(now) if sender is None else f"{line_of(now)}, {sender.state}")
        elif now.signal == "lost" and not is_awaited:
            # It was never there, and so is not lost.
            is_awaited = True
            sys.stderr.write(f"live: waiting for the source: {now.reason}\n")
        if recorder is not None and not trouble and (trouble := recorder.state.trouble):
            # While there is time to begin another.
            sys.stderr.write(f"live: the recording ended early ({trouble})\n")
        if seconds is not None and passed >= seconds:
            return
        if now.made == 0 and passed > PATIENCE:
            raise UserError(now.reason or f"no frame in {PATIENCE:.0f} s")
    now = session.status()
    if now.signal == "failed":
        raise UserError(now.reason)


def line_of(now: LiveStatus) -> str:
    """How a session stands, in a line."""
    if not now.is_live:
        return f"{now.signal.upper()}: {now.reason}" if now.reason else now.signal.upper()
    delay = "" if now.to_ready is None else f", {now.to_ready}"
    return f"LIVE, {now.frames_per_second:.0f} frames/s{delay}, {now.dropped} dropped"


def _facts(now: LiveStatus, seconds: float) -> dict[str, Any]:
    return {
        "told": now.told,
        "seconds": seconds,
        "arrived": now.arrived,
        "made": now.made,
        "dropped": now.dropped,
        "times_lost": now.times_lost,
        "ends": now.signal,
        "reason": now.reason,
        "milliseconds_from_arrival_to_enhanced": now.to_ready,
        "milliseconds_from_eye_to_eye": now.apart,
        "unpaired": now.unpaired,
    }


def _say(
    facts: dict[str, Any],
    last: LiveStatus,
    recording: Recording | None,
    sending: Sending | None,
    as_json: bool,
) -> None:
    if as_json:
        of_outputs = {"recording": recording, "sending": sending}
        facts = facts | {name: told for name, told in of_outputs.items() if told is not None}
        sys.stdout.write(strict_json(provenance(**facts)) + "\n")
        return
    text = f"{facts['source']} ({last.told}): {last.made} frames in {facts['seconds']:.1f} s"
    text += f", {last.dropped} dropped; from arrival to enhanced {last.to_ready}\n"
    if last.apart is not None:
        text += (
            f"from eye to eye {last.apart}; pairs left out, more than half a frame apart: {last.unpaired}\n"
        )
    if recording is not None:
        files = f" in {recording.files} files, the last of them this" if recording.files > 1 else ""
        text += f"{recording.path}: {recording.pictures} images, {recording.seconds:.1f} s recorded{files}, "
        text += f"{recording.left_out} left out\n"
    if sending is not None:
        text += f"{sending.address}: {sending.sent} images sent by OpenIGTLink, {sending.left_out} left out\n"
    sys.stdout.write(text)


def _list(as_json: bool, found: list[dict[str, Any]]) -> None:
    if as_json:
        sys.stdout.write(strict_json(provenance(devices=found)) + "\n")
    elif not found:
        sys.stdout.write("no capture device\n")
    for one in () if as_json else found:
        sys.stdout.write(f"{one['where']}  {one['name']}\n")
