"""What a user can do with the tuning grid, as functions on the state."""

from __future__ import annotations

from app.enhancement.contact_sheet import columns_of
from app.enhancement.parameter_grid import Axis, Setting, settings
from app.errors import UserError
from app.gui.actions import actions, presenting
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.views.picture_view import PictureView, Room
from app.gui.work.background import Failure
from app.gui.work.tuning import CellRequest, Grid, GridCell


def toggle_tuning(state: AppState) -> None:
    """Its panel is one of those that a bare window and a presentation hide."""
    hidden = state.window.bare or state.presenting.pane is not None
    presenting.leave(state)
    state.tuning.shown, state.window.bare = hidden or not state.tuning.shown, False


def choose_axis(state: AppState, place: int, choice: Choice) -> None:
    """Vary another parameter, or other values of it, with the next grid."""
    first, second = state.tuning.choices
    state.tuning.choices = (choice, second) if place == 0 else (first, choice)


def start_grid(state: AppState) -> None:
    """Try the chosen values on the frame that is shown, all else as it is set now."""
    tuning = state.tuning
    picture = state.picture_request
    if picture is None:
        return
    try:
        axes = [_axis(state, choice) for choice in tuning.choices if choice.name]
        wanted = settings(state.enhancement.params, axes)
    except UserError as error:
        actions.fail(state, str(error).removeprefix("--vary: "))
        return
    columns = columns_of([len(one.values) for one in axes], in_order=True)
    tuning.grid = Grid(picture.with_params(state.enhancement.params), wanted, columns)
    tuning.cells, tuning.running, tuning.chosen, tuning.look = {}, True, None, None


def _axis(state: AppState, choice: Choice) -> Axis:
    """Raises UserError: chosen while another method was on."""
    if not hasattr(state.enhancement.params, choice.name):
        raise UserError(f"{choice.name} is not a parameter of this method: choose another one to vary")
    return choice.axis(whole=isinstance(getattr(state.enhancement.params, choice.name), int))


def stop_grid(state: AppState) -> None:
    """What has been tried stays."""
    state.tuning.running = False


def look_at(state: AppState, setting: Setting | None) -> None:
    """One cell at 100 %, or all of them again."""
    state.tuning.chosen, state.tuning.view = setting, PictureView(zoom=1.0)


def sort_by(state: AppState, measure: str) -> None:
    """The best first by a measure; empty: as varied."""
    state.tuning.sort = measure


def pan_cell(state: AppState, by: tuple[float, float], picture: tuple[int, int], pane: Room) -> None:
    """The cell that is looked at, along with the hand."""
    state.tuning.view = state.tuning.view.panned(by, picture, pane)


def use_setting(state: AppState, setting: Setting) -> None:
    """Enhance by this setting from now on; one step of undo."""
    actions.settle_params(state)
    actions.set_params(state, setting.params)
    actions.settle_params(state)
    state.enhancement.active = True
    actions.announce(state, f"now using {setting.label}")


def take_cell(state: AppState, request: CellRequest, answer: GridCell | Failure) -> None:
    """A cell has been tried; those of an earlier grid are of no use."""
    tuning = state.tuning
    if request.grid is not tuning.grid:
        return
    if isinstance(answer, Failure):
        tuning.running, tuning.chosen = False, None
        actions.fail(state, f"the grid was stopped: {answer.message}")
    elif request.whole:
        tuning.look = answer
    else:
        tuning.cells[request.setting] = answer
        tuning.running = tuning.running and len(tuning.cells) < len(request.grid.settings)
