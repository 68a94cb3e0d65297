"""Clips whose lens is known from a calibration: undistorted images, and pairs that are rectified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from renderer.clip import BoolImage, ByteImage, Clip, ClipError, Frame
from renderer.depth.stereo_pairs import RightEye, right_eye
from renderer.readers.clip_options import StereoLayout
from renderer.readers.image_folders.frames import is_seen_by_assumption
from renderer.readers.lenses.calibration import Calibration
from renderer.readers.lenses.straightening import Straightening, alike, straight_eyes, straightening


def with_calibration(clip: Clip, calibration: Calibration) -> Clip:
    """The clip as a camera without distortion would show it, worked out when a frame is read; lengths of
    pairs are in mm.

    Raises:
        ClipError: a clip that brings a calibration or depth of its own, frames of several sizes, or a
            calibration that does not fit.
    """
    if not is_seen_by_assumption(clip):
        raise ClipError(f"expected a clip without a calibration of its own, got one with: {clip.path}")
    if clip.has_depth:
        wanted = "expected a clip without depth maps, which would not fit undistorted images"
        raise ClipError(f"{wanted}, got one with: {clip.path}")
    if not clip.has_one_size:
        raise ClipError(f"expected images of one size, as a calibration is of one, got several: {clip.path}")
    right = right_eye(clip)
    try:
        return _of_one(clip, calibration) if right is None else _of_two(clip, right, calibration)
    except ValueError as error:
        raise ClipError(f"calibration: {error}{_way(clip, calibration)}: {clip.path}") from error


def _way(clip: Clip, calibration: Calibration) -> str:
    """What a person may do whose video is twice as wide or as high as the calibration's images."""
    full, (width, height) = calibration.lens.size, clip.size
    if full is None or clip.format != "video":
        return ""
    halves: dict[StereoLayout, tuple[int, int]] = {
        "side-by-side": (width // 2, height),
        "top-bottom": (width, height // 2),
    }
    layout = next((name for name, half in halves.items() if alike(full, half)), None)
    way = f"set Eyes (--stereo {layout})"
    return f"; if a frame holds both eyes: {way}" if layout else ""


def _of_one(clip: Clip, calibration: Calibration) -> Clip:
    which = ", the left eye's" if calibration.right is not None else ""
    said = f"images are undistorted by the calibration of the lens{which}"
    if calibration.found is not None:
        k1, deviation = calibration.lens.coefficients[0], calibration.found.deviation
        said = (
            "images are undistorted: the lens bends straight lines, as the motion of the camera shows "
            f"(k1 = {k1:.3f}, standard deviation {deviation:.3f}); it is found by the program, not measured "
            "(--leave-out lens trains on the images as they are)"
        )
    return _straight(clip, straightening(calibration.lens, clip.size, clip.pixel_aspect), said)


def _of_two(clip: Clip, right: RightEye, calibration: Calibration) -> Clip:
    if right.size != clip.size:
        raise ValueError(f"expected eyes of one size, got {clip.size} and {right.size}")
    eyes = straight_eyes(calibration, clip.size, clip.pixel_aspect)
    said = f"pairs are rectified by the calibration of both eyes, {eyes.baseline:.4g} mm apart"
    return replace(
        _straight(clip, eyes.left, said),
        read_right=lambda index: eyes.right.image(right.read(index)),
        baseline=eyes.baseline,
        unit="mm",
    )


def _straight(clip: Clip, by: Straightening, said: str) -> Clip:
    mask, seen = _remembering(by.mask), clip.read_visible

    def read_visible(index: int) -> BoolImage | None:
        visible = seen(index) if seen else None
        return None if visible is None else by.mask(visible)

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        masks = mask(frame.tissue_mask), mask(frame.evaluation_mask)
        image = by.image(frame.image)
        return replace(frame, image=image, camera=by.camera, tissue_mask=masks[0], evaluation_mask=masks[1])

    def read_image(index: int) -> ByteImage:
        return by.image(clip.read_image(index))

    return replace(
        clip,
        cameras=(by.camera,) * len(clip),
        read_frame=read_frame,
        read_image=read_image,
        read_visible=seen and read_visible,
        calibrated=True,
        notices=(*clip.notices, said),
    )


def _remembering(change: Callable[[BoolImage], BoolImage]) -> Callable[[BoolImage], BoolImage]:
    """The last mask is kept: most clips have one for all frames. Frames are read from any thread."""
    last: list[tuple[BoolImage, BoolImage]] = []

    def changed(mask: BoolImage) -> BoolImage:
        kept = last[0] if last else None
        if kept is None or kept[0] is not mask:
            kept = mask, change(mask)
            last[:] = [kept]
        return kept[1]

    return changed
