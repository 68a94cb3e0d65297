"""How long the rest of a series of similar steps takes."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.kernels.progress import rounded


@dataclass(frozen=True)
class Pace:
    """The first step opens files and may compile kernels: it counts for nothing."""

    first: tuple[int, float] | None = None
    """How many were done when the clock was first looked at after a step, and that clock."""
    done: int = 0
    now: float = 0.0

    def after(self, done: int, now: float) -> Pace:
        """When so many are done."""
        first = self.first or ((done, now) if done else None)
        return replace(self, first=first, done=done, now=now)

    def seconds_left(self, total: int) -> float | None:
        """Until all are done; None: not known yet."""
        if self.first is None or self.done == self.first[0]:
            return None
        each = (self.now - self.first[1]) / (self.done - self.first[0])
        return each * (total - self.done)

    def told(self, total: int) -> str:
        """In words: what is being done, and for how long."""
        if self.done == 0:
            return "Preparing the first frame" if total > 1 else "Preparing"
        if self.done >= total:
            return "Saving the file"
        left = self.seconds_left(total)
        return f"{self.done} of {total}" + (f" · {rounded(left)} left" if left is not None else "")
