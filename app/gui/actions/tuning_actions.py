"""What a user can do with the tuning grid, as functions on the state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from app.console.shell import command
from app.enhancement.amounts import spaced
from app.enhancement.contact_sheet import columns_of
from app.enhancement.methods import preset_of
from app.enhancement.parameter_grid import Axis, Setting, settings
from app.enhancement.setting_words import LABELS, said
from app.errors import UserError
from app.files.provenance import stamp
from app.gui.actions import actions, enhancement_actions, presenting
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.views.picture_view import PictureView
from app.gui.work.background import Failure
from app.gui.work.tuning import CellRequest, Grid, GridCell
from app.gui.work.writing import WriteRequest
from app.sweeps.settings import Enhancing
from app.sweeps.spec_file import spec_text

LEAST_SIZE, MOST_SIZE = 0.5, 4.0
"""Of tiles, of the size in which all columns are in sight."""


def toggle_tuning(state: AppState) -> None:
    """Its panel is one of those that a bare window and a presentation hide."""
    hidden = state.window.bare or state.presenting.pane is not None
    presenting.leave(state)
    state.tuning.shown, state.window.bare = hidden or not state.tuning.shown, False
    state.tuning.asked = state.tuning.shown


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
    axes, wanted = _wanted(state)
    if not wanted:
        return
    columns = columns_of([len(one.values) for one in axes], in_order=True)
    if picture.of_clip == "later":
        # A grid keeps what it began with: its maker measures the clip.
        picture = replace(picture, of_clip=None)
    tuning.grid = Grid(picture.with_params(state.enhancement.params), wanted, columns)
    tuning.cells, tuning.running, tuning.chosen, tuning.whole = {}, True, None, None


def _wanted(state: AppState) -> tuple[list[Axis], tuple[Setting, ...]]:
    """What is varied, and every combination of it; nothing, with a word, where that makes no grid."""
    chosen = [choice for choice in state.tuning.choices if _is_of_method(state, choice)]
    if reason := _why_not(chosen):
        actions.fail(state, reason)
        return [], ()
    try:
        axes = [_axis(state, choice) for choice in chosen]
        return axes, settings(state.enhancement.params, axes)
    except UserError as error:
        actions.fail(state, str(error).removeprefix("--vary: "))
        return [], ()


def save_sweep(state: AppState) -> None:
    """The chosen values as a sweep over evenly spread frames of the open clip: a file among the exports. The
    command that runs it is in the log, to copy."""
    clip, chosen = state.source.clip, state.enhancement
    axes, wanted = _wanted(state)
    if clip is None or not wanted:
        return
    path = state.export_folder / f"{clip.path.stem}-sweep-{stamp()}.toml"
    method, params = preset_of(chosen.params), chosen.params
    fixed = Enhancing(method, params, chosen.pixels, chosen.scope, state.source.options)
    text = spec_text(clip.path.absolute(), fixed, {one.name: one.values for one in axes})
    request = WriteRequest(
        path, text.encode(errors="surrogateescape"), "the sweep was not saved", announced=True
    )
    state.window.wishes += (request,)
    kept_out = {
        "the range of frames": state.source.part.trim,
        "the calibration of the lens": state.source.options.calibration,
    }
    if lost := [name for name, value in kept_out.items() if value is not None]:
        actions.say(state, f"{path.name} does not hold {' and '.join(lost)}: it tries frames without")
    actions.say(state, command("sweep", path, "--out", path.with_suffix("")))


def _why_not(chosen: Sequence[Choice]) -> str:
    """Why these make no grid, in the words of the panel; empty where they do."""
    names = [choice.name for choice in chosen]
    if not names:
        return "There is nothing to try: choose a parameter for the rows or the columns."
    if len(set(names)) < len(names):
        return f"Rows and columns are both of {LABELS[names[0]]}: choose two different parameters."
    return ""


def _is_of_method(state: AppState, choice: Choice) -> bool:
    """Else it was chosen while another method was on, and is not shown as chosen."""
    return bool(choice.name) and hasattr(state.enhancement.params, choice.name)


def _axis(state: AppState, choice: Choice) -> Axis:
    """Evenly spaced as its slider shows it."""
    values = spaced(choice.name, choice.first, choice.last, choice.count)
    if values is not None:
        return Axis(choice.name, values)
    return choice.axis(whole=isinstance(getattr(state.enhancement.params, choice.name), int))


def stop_grid(state: AppState) -> None:
    """What has been tried stays."""
    state.tuning.running = False


def look_at(state: AppState, setting: Setting | None) -> None:
    """One cell as large as it fits, beside the original, or all of them again."""
    if setting is None or state.tuning.chosen is None:
        state.tuning.view = PictureView(pixel_aspect=state.picture.view.pixel_aspect)
    state.tuning.chosen = setting


def is_looking(state: AppState) -> bool:
    """One cell of the tuning grid fills the panel."""
    return state.tuning.in_sight and state.tuning.chosen is not None


def go(state: AppState, right: int = 0, down: int = 0) -> None:
    """From the cell that is looked at to its neighbour in the grid, where that is tried already."""
    tuning, order = state.tuning, state.tuning.in_order
    if tuning.chosen not in order:
        return
    row, column = divmod(order.index(tuning.chosen), tuning.columns)
    column, row = column + right, row + down
    place = row * tuning.columns + column
    if 0 <= column < tuning.columns and 0 <= place < len(order) and order[place] in tuning.cells:
        look_at(state, order[place])


def resize_tiles(state: AppState, size: float) -> None:
    """Show tiles at this multiple of their usual size, within its limits."""
    state.tuning.size = min(max(size, LEAST_SIZE), MOST_SIZE)


def sort_by(state: AppState, measure: str) -> None:
    """The best first by a measure; empty: as varied."""
    state.tuning.sort = measure


def use_setting(state: AppState, setting: Setting) -> None:
    """Enhance by this setting of the grid from now on, as it was tried; one step of undo."""
    assert state.tuning.grid is not None
    picture = state.tuning.grid.picture
    enhancement_actions.enhance_by(state, setting.params, picture.scope, picture.pixels, said(setting))


def take_cell(state: AppState, request: CellRequest, answer: GridCell | Failure) -> None:
    """A cell has been tried; those of an earlier grid are of no use."""
    tuning = state.tuning
    if request.grid is not tuning.grid:
        return
    if isinstance(answer, Failure):
        tuning.running, tuning.chosen = False, None
        actions.fail(state, f"the grid was stopped: {answer.message}")
    elif request.whole:
        tuning.whole = answer
    else:
        tuning.cells[request.setting] = answer
        tuning.running = tuning.running and len(tuning.cells) < len(request.grid.settings)
