"""The clip that a run was trained on, and its frames as they were trained on."""

from __future__ import annotations

from pathlib import Path

from app.enhancement.methods import MethodEnhancer
from app.errors import UserError
from app.runs.run_folder import Enhancement, RunRecord
from renderer.clip import ByteImage, Clip, Frame
from renderer.sources import open_clip


def run_clip(record: RunRecord) -> Clip:
    """The part of the clip that the run was trained on. Raises UserError when it is not the same any more,
    ClipError when the run's tool masks are not."""
    path = Path(record.clip.path)
    clip = open_clip(path, record.clip.options)
    if not record.clip.is_of(path):
        raise UserError(f"expected the clip that the run was trained on, got changed files: {path}")
    record.clip.part.require_own_masks(clip)
    return record.clip.as_trained(clip)


def input_clip(clip: Clip, record: RunRecord) -> Clip:
    """The clip with the frames that the run was trained on: its own, or the same enhanced again. Raises
    ValueError: another number of frames than the run's."""
    clip = enhanced_clip(clip, record.enhancement) if record.enhancement else clip
    return clip if record.exposure is None else record.exposure.through(clip)


def enhanced_clip(clip: Clip, enhancement: Enhancement) -> Clip:
    """The clip with every frame enhanced, all with the same statistics."""

    def enhanced(image: ByteImage, frame: Frame) -> ByteImage:
        enhancer = MethodEnhancer()
        enhancer.show(image)
        return enhancer.enhance(enhancement.params, statistics=enhancement.statistics).image

    return clip.with_images(enhanced, f"{clip.name} enhanced")
