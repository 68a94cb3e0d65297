"""Flags that say how a clip is read: those that its layout does not heed are refused."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from app.errors import UserError
from renderer.layouts import Layout, layout_of
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_bare

HEEDING: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "pose_convention": ("endonerf",),
        "evaluation_masks": ("endonerf",),
        "bottom_rows": ("endonerf",),
        "mask_polarity": ("endonerf", "hamlyn", "stereomis", "stereo", "images"),
        "field_of_view": ("image", "video", "stereo", "images"),
        "deinterlacing": ("video",),
        "stereo": ("video",),
    }
)
"""The layouts that heed an option; `_is_matched` says it of the baseline, and all heed the others."""


def require_heeded(flags: argparse.Namespace, path: Path, options: ClipOptions) -> None:
    """Raises UserError: a flag without effect on the clip at `path`; ClipError."""
    given = [name for name in (*HEEDING, "baseline") if name in flags]
    if not given or not path.exists():
        return  # What is not there is said where it is opened.
    layout = layout_of(path)
    for name in given:
        said = f"--{name.replace('_', '-')} {vars(flags)[name]} has no effect"
        if name in HEEDING and layout.name not in HEEDING[name]:
            raise UserError(f"{said} on {layout.title}: {path}")
        if name == "baseline" and not _is_matched(path, layout, options):
            raise UserError(f"{said}, as depth does not come from both eyes: {path}")


def _is_matched(path: Path, layout: Layout, options: ClipOptions) -> bool:
    """Whether depth may come from both eyes: of them, or from disparities beside images."""
    if options.depth == "stereo" or not layout.is_data_set:
        return layout.name != "image" and options.depth in ("auto", "measured", "stereo")
    return options.depth == "auto" and not open_bare(path, options).has_depth
