"""Background work that keeps on disk what a person has set, named or edited."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.gui.actions import actions, edit_actions, preset_actions
from app.gui.state.app_state import AppState
from app.gui.work.background import Channel, Failure
from app.gui.work.file_writing import WriteRequest, write_file
from app.gui.work.presets import KeepPresets, KeptPresets, keep_presets
from app.gui.work.saving_edits import SavedEdits, SaveRequest, keep_edits


@dataclass
class KeepWork:
    """Nothing that is asked for is passed over."""

    files: Channel[WriteRequest, Path] = field(default_factory=lambda: Channel(write_file, depth=256))
    presets: Channel[KeepPresets, KeptPresets] = field(
        default_factory=lambda: Channel(keep_presets, depth=64)
    )
    edits: Channel[SaveRequest, SavedEdits] = field(default_factory=lambda: Channel(keep_edits))

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        return (self.files, self.presets, self.edits)

    def take(self, state: AppState) -> None:
        """Note what has been done since the last frame."""
        while (written := self.files.take()) is not None:
            _take_written(state, *written)
        while (kept := self.presets.take()) is not None:
            preset_actions.take_kept(state, *kept)
        if (saved := self.edits.take()) is not None:
            edit_actions.take_saved(state, *saved)

    def ask(self, state: AppState) -> None:
        """Ask for what has been wished for since the last frame."""
        wishes, state.window.wishes = state.window.wishes, ()
        for wish in wishes:
            if isinstance(wish, KeepPresets):
                self.presets.ask(wish)
            else:
                self.files.ask(wish)
        self.edits.want(state.editing.saving)

    def finish(self, state: AppState) -> None:
        """The window has closed and no worker is left: do what still waits."""
        self.ask(state)
        for channel in self.all:
            while channel.run_waiting():
                pass


def _take_written(state: AppState, request: WriteRequest, answer: Path | Failure) -> None:
    if isinstance(answer, Failure):
        tell = actions.fail if request.announced else actions.say
        tell(state, f"{request.trouble}: {answer.message}")
    elif request.announced:
        actions.announce(state, f"saved {answer.name} in {answer.parent.name}/")
