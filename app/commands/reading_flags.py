"""Flags that say how a clip is read: those that its layout does not heed are refused."""

from __future__ import annotations

import argparse
from itertools import chain
from pathlib import Path
from typing import Final

from app.errors import UserError
from renderer.layouts import LAYOUTS, Layout, layout_of
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_bare

OF_SOME: Final = frozenset(chain.from_iterable(layout.heeds for layout in LAYOUTS))
"""Options that not every layout heeds; `_is_matched` says it of the baseline, and all heed the others."""


def require_heeded(flags: argparse.Namespace, path: Path, options: ClipOptions) -> None:
    """Raises UserError: a flag without effect on the clip at `path`; ClipError."""
    given = [name for name in vars(flags) if name in OF_SOME or name == "baseline"]
    if not given or not path.exists():
        return  # What is not there is said where it is opened.
    layout = layout_of(path)
    for name in given:
        said = f"--{name.replace('_', '-')} {vars(flags)[name]} has no effect"
        if name in OF_SOME and name not in layout.heeds:
            raise UserError(f"{said} on {layout.title}: {path}")
        if name == "baseline" and not _is_matched(path, layout, options):
            raise UserError(f"{said}, as depth does not come from both eyes: {path}")


def _is_matched(path: Path, layout: Layout, options: ClipOptions) -> bool:
    """Whether depth may come from both eyes: of them, or from disparities beside images."""
    if options.depth == "stereo" or not layout.is_data_set:
        return layout.name != "image" and options.depth in ("auto", "measured", "stereo")
    return options.depth == "auto" and not open_bare(path, options).has_depth
