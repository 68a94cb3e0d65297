"""Tool masks of a whole clip, learned from the frames that a person has masked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage
from renderer.tools.network import Network, train_network
from renderer.tools.pixel_features import COUNT, Features, features
from renderer.tools.shrinking import SMALLEST, disc, shrunk, shrunk_mask

PER_FRAME: Final = 3000
"""Pixels of each kind that are learned from, of a frame."""
FOLDS: Final = 5
"""Into which masked frames are dealt to measure how well masks are learned."""

_SMOOTH = 1.5  # px of the small image, standard deviation: single pixels are not trusted.
_OPENING, _CLOSING = 5, 9  # px of the small image: what is thinner is no tool, and no gap in one.


@dataclass(frozen=True, eq=False)
class Example:
    """A frame that a person has masked, as it is learned from."""

    features: Features
    """(h, w, COUNT)."""
    tool: BoolImage
    seen: BoolImage
    """(h, w): False in the dark surround, which teaches nothing."""

    @classmethod
    def of(cls, image: ByteImage, tool: BoolImage, seen: BoolImage) -> Example:
        """Of an RGB image (H, W, 3), its mask and where the endoscope sees something, both (H, W)."""
        return cls(features(shrunk(image)), shrunk_mask(tool), shrunk_mask(seen))


@dataclass(frozen=True, eq=False)
class LearnedTools:
    """Finds tools like those of the examples."""

    network: Network | None
    """None: the examples show none."""

    @classmethod
    def of(cls, examples: Sequence[Example]) -> LearnedTools:
        """The same for the same examples; a second on one core for three frames.

        Half of the pixels that are drawn are tool, half are tissue, however large the tools are. On every
        third frame of the pulling and mesentery clips that is not held out, IoU with the masks that others
        made, from 1, 2 and 3 masked frames: .84, .89 and .91, .73, .77 and .77; by colour alone .73 and .57;
        carried along by optical flow, from one frame, .70 ten frames on and .54 twenty-five on.
        """
        drawn = [_drawn(each, place) for place, each in enumerate(examples)]
        kinds = np.concatenate([np.zeros(0, bool), *(kind for _, kind in drawn)])
        if not kinds.any() or kinds.all():
            return cls(None)
        return cls(train_network(np.concatenate([values for values, _ in drawn]), kinds))

    def find(self, image: ByteImage, seen: BoolImage) -> BoolImage:
        """(H, W), True = tool, of an RGB image (H, W, 3)."""
        height, width = seen.shape
        small = self.find_small(features(shrunk(image)), shrunk_mask(seen))
        soft = cv2.GaussianBlur(small.astype(np.float32), (0, 0), 1.0)
        large = cv2.resize(soft, (width, height), interpolation=cv2.INTER_LINEAR)
        return np.asarray(large > 0.5) & seen

    def find_small(self, values: Features, seen: BoolImage) -> BoolImage:
        """(h, w) of the features of a small image: areas that are neither thin nor tiny."""
        if self.network is None:
            return np.zeros_like(seen)
        likely = self.network.probability(values.reshape(-1, COUNT)).reshape(seen.shape)
        areas = ((cv2.GaussianBlur(likely, (0, 0), _SMOOTH) > 0.5) & seen).astype(np.uint8)
        opened = cv2.morphologyEx(areas, cv2.MORPH_OPEN, disc(_OPENING))
        _, labels, facts, _ = cv2.connectedComponentsWithStats(opened)
        large = facts[:, cv2.CC_STAT_AREA] > SMALLEST * labels.size
        large[0] = False
        closed = cv2.morphologyEx(large[labels].astype(np.uint8), cv2.MORPH_CLOSE, disc(_CLOSING))
        return np.asarray(closed > 0) & seen


def learned_well(examples: Sequence[Example]) -> float | None:
    """IoU of what is learned with what a person has masked, on frames that were not learned from: each is
    left out once. None for fewer than two frames, or where none shows a tool."""
    if len(examples) < 2 or not any(each.tool.any() for each in examples):
        return None
    folds = [examples[start::FOLDS] for start in range(min(FOLDS, len(examples)))]
    both = either = 0
    for place, fold in enumerate(folds):
        others = [each for other, kept in enumerate(folds) if other != place for each in kept]
        learned = LearnedTools.of(others)
        for each in fold:
            found = learned.find_small(each.features, each.seen)
            both += int(np.count_nonzero(found & each.tool))
            either += int(np.count_nonzero(found | each.tool))
    return both / either if either else None


def _drawn(example: Example, place: int) -> tuple[Features, BoolImage]:
    """Features (N, COUNT) and kinds (N,), True = tool, of as many pixels of either kind as there are."""
    random = np.random.default_rng(place)
    tool, seen = example.tool.reshape(-1), example.seen.reshape(-1)
    chosen = [_some(random, np.flatnonzero(seen & (tool == kind))) for kind in (False, True)]
    places = np.concatenate(chosen)
    return example.features.reshape(-1, COUNT)[places], tool[places]


def _some(random: np.random.Generator, places: NDArray[np.int64]) -> NDArray[np.int64]:
    return random.choice(places, min(PER_FRAME, len(places)), replace=False)
