"""What a person can do to the shown model, as functions on the state. No ImGui."""

from __future__ import annotations

from functools import partial
from itertools import takewhile

from app.gui.actions import actions, camera_actions, history_actions
from app.gui.state.app_state import AppState
from app.gui.state.editing import Change, Editing, Step, Tool, tinted_model
from app.gui.work.background import Failure
from app.gui.work.saving_edits import SavedEdits, SaveRequest
from app.gui.work.selecting import Around, Limits, Selected, SelectRequest
from renderer.editing.edits import Combination, Edits
from renderer.editing.history import History
from renderer.editing.regions import Lasso, Present, Range, Rectangle, Region
from renderer.editing.sight import Trait

SHORTEST = 3.0
"""Pixels: a drag that goes nowhere selects nothing."""


def follow(state: AppState) -> None:
    """Another model has come: editing begins anew with it, and with what was saved of it."""
    editing, model = state.editing, state.scene.model
    if model is editing.edited:
        return
    if model is None or model.live or model.is_series:
        state.editing = Editing(edited=model)
        return
    edits = model.saved_edits or Edits.none(len(model.model))
    whole = Edits.none(edits.count).visible
    state.editing = Editing(
        model, History(edits), edits, model, whole, tool=editing.tool, how=editing.how, radius=editing.radius
    )
    _show(state)


def bring_back(state: AppState, edits: Edits) -> None:
    """Edits of the open model from before, which nobody has saved: one step that can be undone."""
    state.editing.history = state.editing.history.then(edits)
    _show(state)


def _show(state: AppState) -> None:
    """The model as the edits leave it."""
    editing = state.editing
    assert editing.base is not None
    edits = editing.edits
    if edits.visible != editing.drawn:
        editing.edited, editing.drawn = editing.base.edited(edits), edits.visible
    assert editing.edited is not None
    state.scene.model = editing.edited
    editing.tinted = tinted_model(editing.edited, edits) if editing.active else None


def why_not_edit(state: AppState) -> str:
    """Why there is nothing to edit, in a sentence."""
    model = state.scene.model
    if model is None:
        return "There is no reconstruction to edit: reconstruct the clip or open a run."
    if model.live:
        return "The reconstruction is not finished: wait for it or continue it, then edit."
    return f"This is {model.split_by_time}, which cannot be edited."


def toggle(state: AppState) -> None:
    """Into edit mode and out of it; edits stay, selected Gaussians lose their colour."""
    editing = state.editing
    if editing.base is None:
        actions.announce(state, why_not_edit(state))
        return
    editing.active, editing.stroke = not editing.active, ()
    _show(state)
    if editing.active:
        state.scene.viewer.flying = state.window.bare = False
        _ask(state, None, "replace")


def choose_tool(state: AppState, tool: Tool) -> None:
    if state.editing.active:
        state.editing.tool, state.editing.stroke = tool, ()


# ---- selecting


def draw_on(state: AppState, pixel: tuple[float, float]) -> None:
    """The drag goes on to a position in the view's picture."""
    editing = state.editing
    if not editing.stroke:
        editing.stroke = (pixel,)
    elif editing.tool == "rectangle":
        editing.stroke = (editing.stroke[0], pixel)
    elif editing.tool == "lasso" and _apart(editing.stroke[-1], pixel) >= SHORTEST:
        editing.stroke = (*editing.stroke, pixel)


def drop_stroke(state: AppState) -> None:
    """Give up the drag under way: it selects nothing."""
    state.editing.stroke = ()


def end_stroke(state: AppState, how: Combination) -> None:
    """Select what was drawn around, or pointed at."""
    editing, stroke = state.editing, state.editing.stroke
    editing.stroke = ()
    if not stroke:
        return
    if editing.tool == "rectangle" and len(stroke) == 2 and _apart(*stroke) >= SHORTEST:
        (left, right), (top, bottom) = (sorted(values) for values in zip(*stroke, strict=True))
        _ask(state, Rectangle(left, top, right, bottom), how)
    elif editing.tool == "lasso" and len(stroke) > 2:
        _ask(state, Lasso(stroke), how)
    elif editing.tool in ("sphere", "box"):
        _ask(state, _around(state, (int(stroke[0][0]), int(stroke[0][1]))), how)


def _apart(one: tuple[float, float], other: tuple[float, float]) -> float:
    return max(abs(one[0] - other[0]), abs(one[1] - other[1]))


def _around(state: AppState, pixel: tuple[int, int]) -> Around:
    """The sphere or the box behind a pixel, with its present size."""
    base = state.editing.base
    radius = state.editing.radius * (base.distance if base else 1.0)
    return Around(pixel, "box" if state.editing.tool == "box" else "sphere", radius)


def select_again(state: AppState) -> None:
    """The last sphere or box with its present size."""
    editing = state.editing
    if editing.center is not None and editing.tool in ("sphere", "box"):
        _ask(state, _around(state, (0, 0)).region(editing.center), editing.how)


def select_range(state: AppState, trait: Trait, limits: Limits) -> None:
    _ask(state, Range(trait, *limits), state.editing.how)


def select_present(state: AppState) -> None:
    """What is drawn at this moment: of a model in windows, the Gaussians of one or two of them."""
    _ask(state, Present(), state.editing.how)


def _ask(state: AppState, wish: Region | Around | None, how: Combination) -> None:
    editing, view = state.editing, state.plain_view_request
    if not editing.active or editing.base is None or view is None:
        return
    request = SelectRequest(editing.base, view, wish, how)
    if editing.wish is None:
        editing.wish = request
        return
    # A slider asks many times over: of two in a row the later one takes all that the earlier would select.
    before = editing.waiting[-1] if editing.waiting else None
    if isinstance(before, SelectRequest) and how == "replace":
        editing.waiting.pop()
    editing.waiting.append(request)


def take_selected(state: AppState, request: SelectRequest, answer: Selected | Failure) -> None:
    """The answer to a wish, and then what was asked for while it was on its way: where it fails, no change
    up to the next selection, as it was meant for what would have been selected."""
    editing = state.editing
    if request is not editing.wish:
        return
    editing.wish = None
    if isinstance(answer, Failure):
        steps = list(takewhile(lambda one: not isinstance(one, SelectRequest), editing.waiting))
        editing.waiting[: len(steps)] = [one for one in steps if one == "save"]
        actions.fail(state, f"nothing was selected: {answer.message}")
    else:
        _take_selection(state, request, answer)
    _go_on(state)


def _take_selection(state: AppState, request: SelectRequest, answer: Selected) -> None:
    editing, mask = state.editing, answer.mask
    editing.limits = answer.limits
    if answer.center is not None:
        editing.center = answer.center
    if mask is not None:
        _do(state, _changed(lambda edits: edits.selecting(mask, request.how)))
    elif request.wish is not None:
        actions.announce(state, camera_actions.NO_SURFACE)


def _go_on(state: AppState) -> None:
    """Do the steps that wait, up to the next selection."""
    editing = state.editing
    while editing.waiting and editing.wish is None:
        later = editing.waiting.pop(0)
        if isinstance(later, SelectRequest):
            editing.wish = later
        elif later == "save":
            save(state)
        else:
            _do(state, later)


# ---- changing


def change(state: AppState, how: Change) -> None:
    """One step of the history; after a selection that is still on its way. None while another model comes."""
    editing = state.editing
    if editing.active and state.source.opening is None:
        _do(state, _changed(how))


def _changed(how: Change) -> Step:
    return lambda history: history.then(how(history.present))


def _do(state: AppState, step: Step) -> None:
    """Do an edit at once, or after a selection that is still being worked out."""
    editing = state.editing
    if editing.wish is not None:
        editing.waiting.append(step)
        return
    editing.history = step(editing.history)
    _show(state)


def crop(state: AppState) -> None:
    """Delete all but the selection; nothing happens without one, as nothing would be left."""
    change(state, lambda edits: edits.cropping() if len(edits.selected) else edits)


delete = partial(change, how=Edits.deleting)
hide = partial(change, how=Edits.hiding)
show_hidden = partial(change, how=Edits.showing)
select_all = partial(change, how=Edits.selecting_all)
select_none = partial(change, how=Edits.selecting_none)
invert = partial(change, how=Edits.inverted)


def undo(state: AppState) -> None:
    """An edit in edit mode, else a parameter."""
    _do(state, History.undone) if state.editing.active else history_actions.undo(state)


def redo(state: AppState) -> None:
    _do(state, History.redone) if state.editing.active else history_actions.redo(state)


# ---- keeping


def save(state: AppState) -> None:
    """Beside the run; of a file of splats, as another file. After a selection that is still on its way, and
    what waits for it."""
    editing = state.editing
    if editing.base is None or editing.run_path is None or editing.saving is not None:
        return
    if editing.wish is not None:
        editing.waiting.append("save")
        return
    editing.saving = SaveRequest(editing.base, editing.run_path, editing.edits, editing.saved, state.time)


def take_saved(state: AppState, request: SaveRequest, answer: SavedEdits | Failure) -> None:
    """They are on disk, or why they are not; what waited for that goes on, unless more was edited since."""
    editing, go = state.editing, None
    if request is editing.saving:
        editing.saving, go, editing.after_saving = None, editing.after_saving, None
    if isinstance(answer, Failure):
        actions.fail(state, f"the edits are not saved: {answer.message}")
        return
    known = answer.replaced_by
    if editing.base is request.base:
        editing.saved = request.edits if known is None else known
    if known is not None:
        reason = "another window has saved edits meanwhile; save again to replace them"
        actions.fail(state, f"the edits are not saved: {reason}")
        return
    if request.base.is_of_run:
        said = f"edits saved beside {answer.path.name}; the trained model is as it was"
    else:
        said = f"edits saved as splat file {answer.path.name}; the file opened is as it was"
    actions.announce(state, said)
    if go is not None:
        actions.leave(state, go)


def answer(state: AppState, reply: str) -> None:
    """To "save the edits?": save, discard or stay."""
    editing, go = state.editing, state.editing.leaving
    editing.leaving = None
    if go is None or reply == "stay":
        return
    if reply == "save":
        editing.after_saving = go
        save(state)
        return
    # A selection that comes later, and what waits for it, would change what has been given up.
    editing.wish = None
    editing.waiting.clear()
    editing.history = History(editing.saved)
    _show(state)
    go()


def choose_how(state: AppState, how: Combination) -> None:
    """What a new selection does to the one that is there."""
    state.editing.how = how


def choose_radius(state: AppState, radius: float) -> None:
    """Set the radius of the sphere, or half the side of the box, in scene distances."""
    state.editing.radius = radius


def move_range(state: AppState, trait: Trait, limits: Limits) -> None:
    """Live, while it is dragged; `edit_actions.select_range` selects with it."""
    state.editing.ranges[trait] = limits
