"""What a folder of images, a layout of a data set, an image or a video is read as."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from statistics import median

import numpy as np

from app.commands.described.fact import Fact, next_steps, notices
from app.files.image_files import read_image
from renderer.camera import Camera
from renderer.clip import Clip, ClipError, Frame
from renderer.depth.clip_depth import BY_BRIGHTNESS, BY_MAPS
from renderer.depth.monocular import monocular_maps
from renderer.depth.stereo_pairs import eye_folders, right_eye
from renderer.evenly import evenly
from renderer.layouts import LAYOUTS, layout_of
from renderer.listing import count, listed
from renderer.readers.clip_options import DEFAULTS, StereoLayout
from renderer.readers.cut_off import cut_off
from renderer.readers.image_files.pictures import SeveralSizes
from renderer.readers.image_folders.frames import is_seen_by_assumption
from renderer.readers.video import eyes_hint
from renderer.readers.video_decoding.stereo_layout import likely_layout
from renderer.readers.video_header import first_frame, read_counted_header
from renderer.sources import open_case, open_clip

TITLES = {layout.name: layout.title for layout in LAYOUTS}
LOOKED_AT = 3
"""Frames, while they take no longer than SECONDS all together."""
SECONDS = 0.4
MOST_LISTED = 100_000
"""Numbers of frames that are missing, one by one."""


def of_clip(path: Path) -> tuple[Fact, ...]:
    """A folder or a picture. Raises ClipError: it cannot be read as a clip."""
    try:
        return tuple(_facts(path, open_clip(path)))
    except SeveralSizes as error:
        if layout_of(path).is_data_set:
            raise
        clip = open_case(path)
        found = len(clip)
        return (
            Fact("what", "images of several sizes: not a clip to train on", {"kind": "pictures"}),
            Fact("frames", count(found, "image"), {"count": found}),
            Fact("missing", str(error), [str(error)]),
            *notices(clip.notices),
            next_steps(path, ("enhance", "PATH", "OUT")),
        )


def of_values(path: Path) -> tuple[Fact, ...] | None:
    """Of an image or a numpy array that stores floats, which is enhanced and not trained on; else None.

    Raises UserError: it is damaged.
    """
    values = read_image(path)
    if values.dtype.kind != "f" or not values.size:
        return None
    height, width = values.shape[:2]
    channels = values.shape[2] if values.ndim == 3 else 1
    low, high = (float(function(values)) for function in (np.nanmin, np.nanmax))
    span = [low, high] if np.isfinite((low, high)).all() else None
    steps = (next_steps(path, ("enhance", "PATH", "OUT.tiff")),) if span and 0 <= low <= high <= 1 else ()
    return (
        Fact("what", f"image of {values.dtype} values: not a clip to train on", {"kind": "values"}),
        Fact("size", f"{width}x{height}, {count(channels, 'channel')}", [width, height, channels]),
        Fact("values", f"{low:.6g} to {high:.6g}", span or []),
        *steps,
    )


INTERLACED = "interlaced; deinterlaced on reading (change with --deinterlacing field or off)"


def of_video(path: Path) -> tuple[Fact, ...]:
    """By its header, and of a file that is not large by its packets. Raises ClipError: it is none."""
    header = read_counted_header(path)
    rate, frames = header.frames_per_second, header.frames
    length = ", as the file states" if header.is_announced else ""
    length += f", {header.seconds:.1f} s" if header.seconds else ""
    pace = "unknown" if rate is None else f"{rate:.4g} a second"
    if not header.is_steady:
        pace = f"varies, {pace} on average"
    first = first_frame(path) if header.stereo is None else None
    looks, hint = (None, "") if first is None else (likely_layout(first), eyes_hint(first))
    cut = cut_off(frames or 0, header.announced) if header.is_cut else ""
    width, height = header.size
    shape = "square" if header.pixel_aspect == 1 else f"{header.pixel_aspect:.3g} (width to height)"
    return (
        Fact("what", "clip: video", "video"),
        Fact("frames", f"{frames or 'unknown number'}{length}", {"count": frames}),
        Fact("frame rate", pace, {"frames_per_second": rate, "steady": header.is_steady}),
        Fact("size", f"{width}x{height}", [width, height]),
        Fact("pixels", shape, header.pixel_aspect),
        Fact("codec", header.codec or "unknown", header.codec),
        *([Fact("bits", f"{header.bits} a colour, read with 8", header.bits)] if header.bits > 8 else []),
        Fact("fields", INTERLACED if header.is_interlaced else "none", header.is_interlaced),
        Fact("sound", header.sound or "none", header.sound),
        *_eyes(header.stereo),
        Fact("camera", _assumed(), {"field_of_view": DEFAULTS.view_angle, "assumed": True}),
        _lens(has_motion=header.stereo is None and frames != 1),
        Fact("unit", "scene units"),
        *notices([*filter(None, [cut, hint])]),
        next_steps(path, *_video_steps(header.stereo, looks)),
    )


def _video_steps(stereo: StereoLayout | None, looks: StereoLayout | None) -> Iterator[tuple[str, ...]]:
    """As the video says, depth of one eye guessed for a camera at rest and for one that moves; then those of
    two eyes, if it looks like them: a person decides."""
    enhance, train = ("enhance", "PATH", "OUT.mp4"), ("train", "PATH", "--run", "RUN")
    yield enhance
    yield from (train,) if stereo else ((*train, "--depth", way) for way in ("brightness", "motion"))
    if looks is not None:
        yield from ((*step, "--stereo", looks) for step in (enhance, train))


def _eyes(stereo: StereoLayout | None) -> tuple[Fact, ...]:
    """What depth a video comes with."""
    if stereo is None:
        lacking = (
            "depth: of a camera that moves --depth motion finds it, of one at rest brightness guesses it"
        )
        return Fact("depth", "none", {"origin": None}), Fact("missing", (lacking,), ["depth", "poses"])
    depth = f"matched between both eyes, which lie {stereo} in each frame"
    lacking = "poses of a camera that moves, and the distance between the eyes (--baseline)"
    return (
        Fact("depth", depth, {"origin": "stereo", "stereo": stereo}),
        Fact("missing", (lacking,), ["poses", "baseline"]),
    )


def _facts(path: Path, clip: Clip) -> Iterator[Fact]:
    eyes = eye_folders(path) if path.is_dir() else ()
    stereo = _has_right(clip)
    # Matching a pair takes its time: of those, only the frames are looked at.
    matched = clip.has_depth and clip.depth_origin == "stereo"
    frames = _looked_at(open_clip(path, replace(DEFAULTS, depth="off")) if matched else clip)
    layout = TITLES[clip.format] + (", left and right" if stereo else "")
    yield Fact("what", f"clip: {layout}", {"layout": clip.format, "stereo": stereo})
    yield _numbers(clip)
    yield Fact("size", f"{clip.size[0]}x{clip.size[1]}", list(clip.size))
    yield _depth(clip, frames)
    yield _masks(frames)
    yield _camera(clip)
    if is_seen_by_assumption(clip):
        yield _lens(has_motion=len(clip) > 1 and not stereo)
    yield Fact("unit", clip.unit)
    yield Fact("held out", count(len(clip.test_indices), "frame"), len(clip.test_indices))
    missing = list(_missing(clip))
    yield Fact("missing", tuple(missing) or "nothing", missing)
    yield from notices([said for said in clip.notices if said != clip.why_no_depth])
    pictures = str(eyes[0]) if eyes and clip.format == "images" else "PATH"
    output = "OUT.png" if clip.format == "image" else "OUT"
    flags = _train(clip)
    train = [] if flags is None else [("train", "PATH", "--run", "RUN", *flags)]
    yield next_steps(path, ("enhance", pictures, output), *train)


def _has_right(clip: Clip) -> bool:
    try:
        return right_eye(clip) is not None
    except ClipError:
        return True


def _looked_at(clip: Clip) -> list[Frame]:
    """A few frames from all over the clip, the fewer the slower they are read."""
    found: list[Frame] = []
    began = time.perf_counter()
    for place in evenly(range(len(clip)), LOOKED_AT):
        found.append(clip.read_frame(place))
        if time.perf_counter() - began > SECONDS:
            break
    return found


def _numbers(clip: Clip) -> Fact:
    """How many, and which numbers are left out between the first and the last."""
    found = [re.findall(r"\d+", Path(label).stem)[-1:] for label in clip.labels]
    numbers = sorted({int(each[0]) for each in found if each})
    if len(numbers) < len(clip) or len(clip) == 1:
        text = f"{len(clip)}, {clip.labels[0]}" if len(clip) == 1 else str(len(clip))
        return Fact("frames", text, {"count": len(clip)})
    step = int(median(two - one for one, two in pairwise(numbers)))
    gaps = [(one + step, two - step) for one, two in pairwise(numbers) if two - one >= 2 * step]
    lost = sum((last - first) // step + 1 for first, last in gaps)
    # A date among numbers makes a gap of billions.
    missing = (
        [each for one, two in gaps for each in range(one, two + 1, step)] if lost <= MOST_LISTED else None
    )
    said = f"{len(clip)}, numbers {numbers[0]} to {numbers[-1]}" + (f" by {step}" if step > 1 else "")
    spans = [str(first) if first == last else f"{first} to {last}" for first, last in gaps]
    lacking = f"; missing {lost}: {listed(spans)}" if lost else ""
    value = {"count": len(clip), "first": numbers[0], "last": numbers[-1], "step": step, "missing": missing}
    return Fact("frames", said + lacking, value)


def _depth(clip: Clip, frames: Sequence[Frame]) -> Fact:
    if not clip.has_depth:
        points = "" if clip.points is None else f", but {len(clip.points.positions)} sparse points"
        why = f": {clip.why_no_depth}" if clip.why_no_depth else points
        return Fact("depth", f"none{why}", {"origin": None, "why": clip.why_no_depth or None})
    origin = clip.depth_origin
    told = {
        "measured": "measured, from the clip's files",
        "beside": "from files beside the images",
        "stereo": "matched between left and right images",
        "monocular": BY_MAPS,
        "brightness": BY_BRIGHTNESS,
    }[origin]
    share = _share([(frame.depth > 0) for frame in frames if frame.depth is not None])
    seen = "" if share is None else f", {100 * share:.0f} % of the pixels"
    return Fact("depth", told + seen, {"origin": origin, "share": share})


def _masks(frames: Sequence[Frame]) -> Fact:
    share = _share([frame.tissue_mask for frame in frames])
    if share is None:
        return Fact("masks", "not checked", {"tissue_share": None})
    used = f"tissue is {100 * share:.0f} % of the pixels"
    text = "none used: every pixel is treated as tissue" if share == 1 else used
    return Fact("masks", text, {"tissue_share": share})


def _share(masks: Sequence[np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]) -> float | None:
    return float(np.mean([mask.mean() for mask in masks])) if masks else None


def _camera(clip: Clip) -> Fact:
    camera = clip.cameras[0]
    is_assumed = is_seen_by_assumption(clip)
    lens = _assumed() if is_assumed else f"focal length {camera.fx:.1f} px"
    intrinsics = {name: getattr(camera, name) for name in ("fx", "fy", "cx", "cy")}
    value = {"fixed": clip.camera_is_fixed, **intrinsics, "assumed": is_assumed}
    if clip.camera_is_fixed:
        still = "no poses: assumed fixed" if is_assumed else "fixed"
        return Fact("camera", f"{still}, {lens}", value)
    way = _way(clip.cameras)
    return Fact("camera", f"moves {way:.3g} {clip.unit}, with poses; {lens}", value | {"way": way})


def _way(cameras: Sequence[Camera]) -> float:
    places = np.array([camera.position for camera in cameras])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def _assumed() -> str:
    return f"field of view {DEFAULTS.view_angle:g} degrees assumed (--field-of-view, or --calibration)"


def _lens(*, has_motion: bool) -> Fact:
    """Of which no calibration is known; `has_motion`: that of a camera may tell it."""
    found = "of a camera that moves --depth motion finds it, " if has_motion else ""
    return Fact("lens", f"treated as free of distortion: {found}--calibration gives it", {"distortion": None})


def _missing(clip: Clip) -> Iterator[str]:
    if not clip.has_depth and clip.points is None:
        yield "depth"
    if is_seen_by_assumption(clip) and len(clip) > 1:
        yield "poses, if the camera moves"
    if clip.depth_origin == "stereo" and clip.has_depth and clip.unit != "mm":
        yield "the baseline (--baseline, or --calibration), for lengths in mm"


def _train(clip: Clip) -> tuple[str, ...] | None:
    """Flags with which it can be trained on; None: it cannot."""
    if clip.has_depth or clip.points is not None:
        return ()
    if not clip.camera_is_fixed:
        return None
    with suppress(ClipError):
        if clip.path.is_dir() and monocular_maps(clip):
            return ("--depth", "monocular")
    return ("--depth", "brightness")
