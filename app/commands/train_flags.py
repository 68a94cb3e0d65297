"""What the flags of `vesselsplat train` ask for: a run that is resumed keeps what no flag says."""

from __future__ import annotations

import argparse
from dataclasses import fields, replace
from itertools import pairwise
from typing import Any, TypeVar, cast

from pydantic import ValidationError

from app.console.flags import parameters, problem
from app.console.frame_numbers import frame_numbers
from app.enhancement.methods import PAPER, EnhancementSettings
from app.errors import UserError
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.run_folder import Input, RunFolder, RunRecord
from app.runs.tool_masks import ToolMasks
from app.runs.train_run import PRESETS, TrainRequest
from renderer.readers.clip_options import ClipOptions
from renderer.train.config import TrainConfig

T = TypeVar("T")


def requested(flags: argparse.Namespace) -> TrainRequest:
    """Raises UserError: values that are none, or there is no run to resume, or none that can be read."""
    run = RunFolder(flags.run)
    began = run.record() if flags.resume else None
    chosen: Input = flags.input or ("original" if began is None else began.input)
    return TrainRequest(
        clip_path=flags.clip,
        run_path=flags.run,
        config=_settings(TrainConfig, flags, None if began is None else began.config),
        clip_options=_settings(ClipOptions, flags, None if began is None else began.clip.options),
        part=_part(flags, WHOLE if began is None else began.clip.wanted),
        input=chosen,
        enhance_params=_look(flags, chosen, began),
        device=flags.device,
        resume=flags.resume,
    )


def _settings(kind: type[T], flags: argparse.Namespace, began: T | None) -> T:
    said = parameters(kind, flags)
    if began is None:
        return said
    names = (one.name for one in fields(cast(Any, kind)) if one.name in flags)
    return cast(T, replace(cast(Any, began), **{name: getattr(said, name) for name in names}))


def _look(flags: argparse.Namespace, chosen: Input, began: RunRecord | None) -> EnhancementSettings:
    """What the frames are enhanced by. Raises UserError when they are not to be."""
    if "preset" in flags and chosen != "enhanced":
        raise UserError("--preset has no effect with --input original: add --input enhanced")
    if "preset" not in flags and began is not None and began.enhancement is not None:
        return began.enhancement.params
    return PRESETS[flags.preset if "preset" in flags else PAPER]


def _part(flags: argparse.Namespace, began: ClipPart) -> ClipPart:
    """What of the clip counts. Raises UserError for numbers that say nothing."""
    numbers = frame_numbers(flags.frames or ())
    if any(after != before + 1 for before, after in pairwise(numbers)):
        said = " ".join(flags.frames)
        raise UserError(f"--frames: expected frames that follow one another to train on, got {said}")
    trim = (numbers[0], numbers[-1]) if numbers else began.trim
    text, view = flags.text_box, flags.view_circle
    if text and not (text[0] < text[2] and text[1] < text[3]):
        said = " ".join(f"{edge:g}" for edge in text)
        raise UserError(f"--text-box: expected LEFT below RIGHT and TOP below BOTTOM, got {said}")
    try:
        text_box = tuple(text) if text else began.mask.text
        mask = replace(began.mask, text=text_box, view=tuple(view) if view else began.mask.view)
    except ValidationError as error:
        raise UserError(problem(error, {"text": "--text-box", "view": "--view-circle"})) from error
    folder = flags.tool_masks
    masks = None if folder is None else ToolMasks(folder=str(folder.absolute()))
    return ClipPart(trim=trim, mask=mask, tool_masks=masks)
