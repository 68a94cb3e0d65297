"""Undo and redo over edits, selections included."""

from __future__ import annotations

from dataclasses import dataclass

from renderer.editing.edits import Edits

MOST = 500
"""Steps that can be undone: with half a million Gaussians each keeps some 100 kB at most."""


@dataclass(frozen=True)
class History:
    """The present edits between those before and those undone; a value."""

    present: Edits
    past: tuple[Edits, ...] = ()
    """Oldest first."""
    future: tuple[Edits, ...] = ()
    """The next to redo comes last."""

    def then(self, edits: Edits) -> History:
        """One step on; what was undone before is gone. Edits that change nothing are no step."""
        if edits == self.present:
            return self
        return History(edits, (*self.past, self.present)[-MOST:])

    def undone(self) -> History:
        """One step back, if there is one."""
        if not self.past:
            return self
        return History(self.past[-1], self.past[:-1], (*self.future, self.present))

    def redone(self) -> History:
        """One step forth again, if there is one."""
        if not self.future:
            return self
        return History(self.future[-1], (*self.past, self.present), self.future[:-1])
