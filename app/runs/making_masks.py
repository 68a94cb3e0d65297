"""Masks of the tools in all frames of a clip: found by colour, or learned from those that a person has drawn;
how well they agree."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Final

from annotated_types import Ge, Interval

from app.runs.dark_surround import lit_part, spread
from app.runs.unmasked_tools import tools_in
from renderer.clip import BoolImage, Clip, Frame
from renderer.evenly import evenly
from renderer.readers.masks.nonzero_masks import read_nonzero
from renderer.tools.agreement import WEAK, Agreement
from renderer.tools.learning import Example, LearnedTools, learned_well
from renderer.tools.mask_files import MaskFiles, MaskOrigin, mask_names, origin_of, write_mask
from renderer.tools.onnx_model import OnnxTools
from renderer.tools.search import find_tools

MOST_EXAMPLES: Final = 24
"""Frames that are learned from, evenly spread: each takes 6 MB."""
Share = Annotated[float, Interval(ge=0, le=1)]
Find = Callable[[Frame], BoolImage]


@dataclass(frozen=True)
class MaskReport:
    """How many masks are made, and how good they are so far."""

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
    weak: tuple[int, ...] = ()
    """Frames where that is low: they should be looked at, the worst first."""
    notices: tuple[str, ...] = ()
    """How masks by hand were paired with frames, as `MaskFiles` has it, and whether they look inverted."""


def make_masks(clip: Clip, folder: Path, by_hand: MaskFiles, model: OnnxTools | None) -> Iterator[MaskReport]:
    """One file a frame: those by hand as they are, all others found by the model, learned from those by hand,
    or found by their colour where there are none. What the clip's own masks leave out is not looked at. What
    is drawn by hand in the folder meanwhile stays.

    Raises:
        ClipError: a frame or a mask by hand cannot be read.
        OnnxError: the model fails.
        OSError: a mask cannot be written.
    """
    lit = lit_part(_read_once(clip))
    learns = model is None and len(by_hand.files) < len(clip)
    taught_by = evenly(sorted(by_hand.files), MOST_EXAMPLES) if learns else []
    examples = [_example(lit, index, by_hand) for index in taught_by]
    report = MaskReport(0, len(by_hand.files), learned_well(examples), notices=by_hand.notices)
    yield report
    find, found_by = _finder(lit, examples, model)
    shares, scores, agreement = list[float](), dict[int, float](), Agreement()
    for index, name in enumerate(mask_names(clip.labels)):
        frame = lit.read_frame(index)
        mask = by_hand.read(index, _size(frame))
        if mask is None:
            mask = _kept(folder / name, find(frame), found_by)
        elif by_hand.files[index] != folder / name:
            write_mask(folder / name, mask, "by hand")
        shares.append(float(mask.mean()))
        if (score := agreement.with_next(frame.image, mask)) is not None:
            scores[index] = score
        yield _report(report, shares, scores)


def _read_once(clip: Clip) -> Clip:
    """The clip whose frames that tell what is left out are kept for when their masks are made."""
    # Training's modules take a while to import; the window must not wait for them.
    from renderer.train.frame_store import FrameStore

    looked_at = spread(range(len(clip)))
    frames = FrameStore.of(map(clip.read_frame, looked_at))
    places = {index: place for place, index in enumerate(looked_at)}

    def read_frame(index: int) -> Frame:
        return frames[places[index]] if index in places else clip.read_frame(index)

    return replace(clip, read_frame=read_frame)


def _kept(path: Path, found: BoolImage, found_by: MaskOrigin) -> BoolImage:
    """The mask that is there from now on: what was found, unless a hand has drawn one meanwhile."""
    if path.is_file() and origin_of(path) == "by hand":
        return read_nonzero(path, (found.shape[1], found.shape[0]))
    write_mask(path, found, found_by)
    return found


def _example(clip: Clip, index: int, by_hand: MaskFiles) -> Example:
    frame = clip.read_frame(index)
    mask = by_hand.read(index, _size(frame))
    assert mask is not None
    return Example.of(frame.image, mask, frame.tissue_mask)


def _size(frame: Frame) -> tuple[int, int]:
    """Width and height."""
    height, width = frame.tissue_mask.shape
    return width, height


def _finder(lit: Clip, examples: list[Example], model: OnnxTools | None) -> tuple[Find, MaskOrigin]:
    if model is not None:
        return lambda frame: model.find(frame.image, frame.tissue_mask), "by a model"
    if not examples:
        found = tools_in(map(lit.read_frame, spread(range(len(lit)))))
        still = () if found is None else found.still
        return lambda frame: find_tools(frame.image, frame.tissue_mask, still), "by colour"
    learned = LearnedTools.of(examples)
    return lambda frame: learned.find(frame.image, frame.tissue_mask), "learned"


def _report(begun: MaskReport, shares: list[float], scores: Mapping[int, float]) -> MaskReport:
    weak = sorted((index for index, score in scores.items() if score < WEAK), key=scores.__getitem__)
    return replace(
        begun,
        done=len(shares),
        with_tools=sum(share > 0 for share in shares),
        share=sum(shares) / len(shares),
        agreement=sum(scores.values()) / len(scores) if scores else None,
        weak=tuple(weak),
    )
