"""What has been done to a model by hand: which Gaussians are deleted, hidden and selected."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from renderer.editing.mask import Mask
from renderer.gaussians import DynamicGaussians

Combination = Literal["replace", "add", "subtract", "intersect"]


@dataclass(frozen=True)
class Edits:
    """A value: every change gives another one. The model itself is never touched.

    Only what can be seen can be selected: neither what is deleted nor what is hidden, which is thereby safe
    from every change until it is shown again.
    """

    deleted: Mask
    hidden: Mask
    selected: Mask

    @classmethod
    def none(cls, count: int) -> Edits:
        """Of a model of `count` Gaussians, nothing done."""
        return cls(Mask(count), Mask(count), Mask(count))

    @property
    def count(self) -> int:
        """Gaussians of the model before any change."""
        return self.deleted.count

    @property
    def visible(self) -> Mask:
        return ~(self.deleted | self.hidden)

    @property
    def is_empty(self) -> bool:
        """The model is drawn whole."""
        return not self.deleted.bits and not self.hidden.bits

    # ---- selection

    def selecting(self, found: Mask, how: Combination) -> Edits:
        """With those of `found` that can be seen in place of the selection, or combined with it."""
        before, found = self.selected, found & self.visible
        selected = {
            "replace": found,
            "add": before | found,
            "subtract": before - found,
            "intersect": before & found,
        }[how]
        return replace(self, selected=selected)

    def selecting_all(self) -> Edits:
        return replace(self, selected=self.visible)

    def selecting_none(self) -> Edits:
        return replace(self, selected=Mask(self.count))

    def inverted(self) -> Edits:
        """With what can be seen and was not selected."""
        return replace(self, selected=self.visible - self.selected)

    # ---- changes

    def deleting(self) -> Edits:
        """Without the selected Gaussians."""
        return replace(self, deleted=self.deleted | self.selected, selected=Mask(self.count))

    def cropping(self) -> Edits:
        """Without those that can be seen and are not selected."""
        return self.inverted().deleting()

    def hiding(self) -> Edits:
        """The selected Gaussians are not drawn, and safe, until they are shown again."""
        return replace(self, hidden=self.hidden | self.selected, selected=Mask(self.count))

    def showing(self) -> Edits:
        """All that was hidden can be seen again."""
        return replace(self, hidden=Mask(self.count))

    def applied(self, model: DynamicGaussians) -> DynamicGaussians:
        """What can be seen of the model, at all times. Raises ValueError for another count of Gaussians."""
        if len(model) != self.count:
            raise ValueError(f"expected the edited model of {self.count} Gaussians, got one of {len(model)}")
        return model if self.is_empty else model.rows(self.visible.indices())
