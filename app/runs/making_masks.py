"""Masks of the tools in all frames of a clip: found by colour, or learned from those that a person has drawn;
how well they agree."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from annotated_types import Ge, Interval

from app.runs.dark_surround import lit_field, spread
from renderer.clip import BoolImage, Clip, Frame
from renderer.tools.agreement import WEAK, Agreement
from renderer.tools.learning import Example, LearnedTools, learned_well
from renderer.tools.mask_files import MaskOrigin, mask_names, masks_in, write_mask
from renderer.tools.onnx_model import OnnxTools
from renderer.tools.search import find_tools

Share = Annotated[float, Interval(ge=0, le=1)]
Find = Callable[[Frame], BoolImage]


@dataclass(frozen=True)
class MaskReport:
    """How far it is, and of the frames so far how well."""

    done: Annotated[int, Ge(0)]
    given: Annotated[int, Ge(0)]
    """Masks by hand that the others are learned from."""
    held_out: Share | None
    """IoU on masks by hand that were left out of the learning, each once; None for fewer than two."""
    with_tools: Annotated[int, Ge(0)] = 0
    """Frames."""
    share: Share = 0.0
    """Of all pixels."""
    agreement: Share | None = None
    """Mean IoU of each mask with that of the frame before, moved along by optical flow."""
    weak: tuple[str, ...] = ()
    """Labels of frames where that is low: they should be looked at, the worst first."""


def drawn_in(clip: Clip, folder: Path) -> dict[int, BoolImage]:
    """Masks by hand, by frame. Raises ClipError: the folder holds none, or one that cannot be read."""
    files = masks_in(folder, clip.labels)
    sizes = {index: (clip.cameras[index].width, clip.cameras[index].height) for index in files.files}
    read = {index: files.read(index, size) for index, size in sizes.items()}
    return {index: mask for index, mask in read.items() if mask is not None}


def make_masks(
    clip: Clip, folder: Path, by_hand: Mapping[int, BoolImage], model: OnnxTools | None = None
) -> Iterator[MaskReport]:
    """One file a frame: those by hand as they are, all others found by the model, learned from those by hand,
    or found by their colour where there are none. What the clip's own masks leave out is not looked at.

    Raises:
        ClipError: a frame cannot be read.
        OnnxError: the model fails.
        OSError: a mask cannot be written.
    """
    lit = _lit(clip)
    frames = ((lit.read_frame(index), mask) for index, mask in sorted(by_hand.items()))
    examples = [Example.of(frame.image, mask, frame.tissue_mask) for frame, mask in frames]
    report = MaskReport(0, len(by_hand), learned_well(examples) if model is None else None)
    yield report
    find, found_by = _finder(examples, model)
    shares, scores, agreement = list[float](), dict[str, float](), Agreement()
    for index, name in enumerate(mask_names(clip.labels)):
        frame, drawn = lit.read_frame(index), by_hand.get(index)
        mask, origin = (find(frame), found_by) if drawn is None else (drawn, "by hand")
        write_mask(folder / name, mask, origin)
        shares.append(float(mask.mean()))
        if (score := agreement.with_next(frame.image, mask)) is not None:
            scores[clip.labels[index]] = score
        yield _report(report, shares, scores)


def _lit(clip: Clip) -> Clip:
    """Without its dark surround."""
    field = lit_field(map(clip.read_frame, spread(range(len(clip)))))
    return clip if field is None else clip.within(field.mask())


def _finder(examples: list[Example], model: OnnxTools | None) -> tuple[Find, MaskOrigin]:
    if model is not None:
        return lambda frame: model.find(frame.image, frame.tissue_mask), "by a model"
    if not examples:
        return lambda frame: find_tools(frame.image, frame.tissue_mask), "by colour"
    learned = LearnedTools.of(examples)
    return lambda frame: learned.find(frame.image, frame.tissue_mask), "learned"


def _report(begun: MaskReport, shares: list[float], scores: Mapping[str, float]) -> MaskReport:
    weak = sorted((label for label, score in scores.items() if score < WEAK), key=scores.__getitem__)
    return MaskReport(
        len(shares),
        begun.given,
        begun.held_out,
        sum(share > 0 for share in shares),
        sum(shares) / len(shares),
        sum(scores.values()) / len(scores) if scores else None,
        tuple(weak),
    )
