"""What the window writes on request: images, exports and batches, with their panels."""

from __future__ import annotations

from pathlib import Path

from app.gui.actions import batch_actions, export_actions
from app.gui.frame.dialogs import Dialogs
from app.gui.panels.batches import Asking, draw_batches
from app.gui.panels.export import draw_export
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels


class Writing:
    """Made in the background; `dialogs` chooses files and folders."""

    def __init__(self, state: AppState, channels: Channels, dialogs: Dialogs) -> None:
        self._state, self._channels = state, channels
        self._asking = Asking(
            folder=lambda: dialogs.ask("folder", self._add),
            file=lambda: dialogs.ask("file", self._add),
            target=lambda: dialogs.ask("folder", self._into),
            start=self.start_batch,
            cancel=self.cancel_batch,
        )

    def draw(self) -> None:
        draw_export(self._state, self.export, self.cancel_export)
        draw_batches(self._state, self._asking)

    def save_picture(self) -> None:
        """Ask for a PNG of what is shown."""
        if (request := export_actions.save_request(self._state)) is not None:
            self._channels.saving.ask(request)

    def export(self, what: export_actions.What) -> None:
        """Ask for an export, made a step at a time."""
        if (request := export_actions.export_request(self._state, what)) is not None:
            self._channels.exports.ask(request)

    def cancel_export(self) -> None:
        """Nothing of it is left behind."""
        self._channels.exports.cancel()
        export_actions.cancelled(self._state)

    def start_batch(self) -> None:
        """Ask for all that is listed to be enhanced, a picture at a time."""
        if (request := batch_actions.batch_request(self._state)) is not None:
            self._channels.batches.ask(request)

    def cancel_batch(self) -> None:
        """What is whole stays."""
        self._channels.batches.cancel()
        batch_actions.cancelled(self._state)

    def _add(self, path: Path) -> None:
        batch_actions.add_input(self._state, path)

    def _into(self, path: Path) -> None:
        batch_actions.choose_folder(self._state, path)
