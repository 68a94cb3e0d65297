"""The session: taken from the state, given back to it, and autosaved."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import groupby
from pathlib import Path

from app.errors import UserError
from app.files.legible import located
from app.gui.actions import actions, edit_actions, enhancement_actions, second_actions
from app.gui.session_file import (
    MOST_STEPS,
    SUFFIX,
    Case,
    Session,
    SessionSource,
    SummaryDraft,
    SummaryPicture,
    UnsavedEdits,
    autosave_path,
)
from app.gui.state.app_state import AppState
from app.gui.state.choosing import Kind
from app.gui.views.key_words import with_keys
from app.gui.work.background import Failure
from app.gui.work.opening import Opened, OpenRequest, SourceLost
from app.gui.work.writing import SessionRequest
from app.runs.run_edits import packed, unpacked

UNNAMED = "session"
AUTOSAVE_SECONDS = 1.0
"""At least so long between two sessions that are saved in passing."""


def snapshot(state: AppState, folder: Path) -> Session:
    """The session as it stands, for a file in `folder`."""
    run, draft = _run_of_source(state), state.runs.reconstruction
    return Session(
        source=SessionSource.of(state.source.path, folder) if state.source.path else None,
        run=SessionSource.of(run, folder) if run else None,
        second=SessionSource.of(beside, folder) if (beside := _second(state)) else None,
        clip_options=state.source.reading,
        part=state.source.part,
        edits=_unsaved(state),
        frame=state.timeline.frame_index,
        frozen=state.timeline.frozen_index,
        params=state.enhancement.params,
        past=tuple(params for params, _ in groupby(step.params for step in state.enhancement.past))[
            -MOST_STEPS:
        ],
        scope=state.enhancement.scope,
        pixels=state.enhancement.pixels,
        enhancing=state.enhancement.active,
        stored=dict(state.enhancement.stored),
        comparison=state.comparing.chosen,
        zoom=state.picture.view.zoom,
        center=state.picture.view.center,
        linked=state.scene.linked,
        view_time=state.scene.own_time,
        free=state.scene.viewer.free,
        views=state.scene.cameras.views,
        view_kind=state.scene.kind,
        snapped=state.scene.viewer.snapped,
        blend=state.scene.viewer.blend,
        config=draft.config,
        input=draft.input,
        kept=draft.kept,
        run_name=draft.name,
        varied=state.tuning.choices,
        tuning_shown=state.tuning.shown,
        sort=state.tuning.sort,
        notes=state.session.notes,
        summary=_summary(state, folder),
    )


def _run_of_source(state: AppState) -> Path | None:
    """The reconstruction that is shown, where it is of what is open: another clip may have been opened since
    it was begun. Where a model has unsaved edits, the one that they are of; None for a file of splats."""
    run, clip, editing = state.runs.reconstruction, state.source.clip, state.editing
    if editing.is_unsaved and editing.run_path != run.run_path:
        return editing.run_path if editing.is_of_run else None
    if run.request is None or clip is None or state.source.path == run.run_path:
        return run.run_path
    return run.run_path if clip.lies_at(run.request.clip_path) else None


def _summary(state: AppState, folder: Path) -> SummaryDraft:
    """As seen from a folder."""
    pictures = (
        SummaryPicture(SessionSource.of(item.path, folder), item.note) for item in state.summary.items
    )
    return SummaryDraft(title=state.summary.title, notes=state.summary.notes, pictures=tuple(pictures))


def _second(state: AppState) -> Path | None:
    """Where what is in the second 3D view lies, or what will be in a moment."""
    second = state.scene.second
    if second.opening is not None:
        return second.opening.path
    return second.model.path if second.model is not None else None


def _unsaved(state: AppState) -> UnsavedEdits | None:
    """Edits of the open model that are not kept beside its run."""
    editing = state.editing
    if editing.base is None or not editing.is_unsaved:
        return None
    return UnsavedEdits(editing.edits.count, *packed(editing.edits))


def restore(state: AppState, session: Session, second: Path | None = None) -> None:
    """All of it but the sources, which are open by now; but what is in the second 3D view, which is at
    `second`, is asked for."""
    if session.part is not None and state.source.clip is not None:
        state.source.part = session.part
    if session.edits is not None:
        _restore_edits(state, session.edits)
    actions.seek(state, session.frame)
    last = len(state.source.clip) - 1 if state.source.clip is not None else 0
    state.timeline.frozen_index = min(session.frozen, last) if session.frozen is not None else None
    state.enhancement.params = session.params
    state.enhancement.scope, state.enhancement.pixels = session.scope, session.pixels
    state.enhancement.active = session.enhancing
    state.enhancement.stored = dict(session.stored)
    state.comparing.chosen = session.comparison.wiped(session.comparison.wipe)
    state.picture.view = replace(state.picture.view, zoom=session.zoom, center=session.center)
    state.scene.linked, state.scene.own_time = session.linked, session.view_time
    _restore_views(state, session)
    draft = state.runs.reconstruction
    draft.name, draft.kept = session.run_name, session.kept
    draft.config, draft.input = session.config, session.input
    if len(session.varied) == 2:
        state.tuning.choices = (session.varied[0], session.varied[1])
    state.tuning.shown = session.tuning_shown
    state.tuning.sort = session.sort
    state.session.notes, state.session.notes_asked = session.notes, bool(session.notes)
    if second is not None:
        second_actions.open_second(state, second)
    elif session.second is not None:
        actions.say(state, f"the second view is empty: {Path(session.second.path).name} is no longer there")
    enhancement_actions.rebase(state, session.past or (session.params,))


def offer_to_find(state: AppState, lost: SourceLost) -> None:
    """Beside the trouble: a person says where the clip of a run, or what a session is of, lies now, and it is
    opened with that."""

    def open_with(state: AppState, source: Path) -> None:
        actions.open_request(state, OpenRequest(lost.asked, source=source))

    kind: Kind = "file" if lost.old.suffix else "folder"
    if state.window.banner is not None:
        find = partial(actions.choose_path, state, kind, open_with)
        state.window.banner = replace(state.window.banner, find=find)


def _offers_to_find(state: AppState) -> bool:
    return state.window.banner is not None and state.window.banner.find is not None


def _restore_edits(state: AppState, kept: UnsavedEdits) -> None:
    """They are there again, and still unsaved; those of another model are left out, which is said."""
    edit_actions.follow(state)
    base = state.editing.base
    count = len(base.model) if base is not None else 0
    if count != kept.gaussians:
        said = f"they are for {kept.gaussians} Gaussians, the model has {count}"
        # A run that can still be found brings them along: the offer to find it stays.
        tell = actions.say if _offers_to_find(state) else actions.fail
        tell(state, f"unsaved edits in the session were not restored: {said}")
        return
    try:
        edits = unpacked(kept.deleted, kept.hidden, count, Path("session"))
    except UserError as error:
        actions.fail(state, f"unsaved edits in the session were not restored: {error}")
        return
    edit_actions.bring_back(state, edits)
    actions.announce(state, with_keys("unsaved edits of the model were restored: Ctrl+Shift+K saves them"))


def _restore_views(state: AppState, session: Session) -> None:
    state.scene.kind = session.view_kind
    state.scene.viewer.snapped = session.snapped and state.has_frames
    state.scene.viewer.blend = session.blend
    if session.free is not None:
        state.scene.viewer.free = session.free
    if session.views is not None:
        state.scene.cameras.views = session.views


def save(state: AppState) -> None:
    """A session file of what is open and how it is set, written in the background: again where it was opened
    or saved before, else by a name that is asked for."""
    if state.session.path is None:
        save_as(state)
    elif has_content(state):
        path = state.session.path
        state.window.wishes += (SessionRequest(path, snapshot(state, path.parent), in_passing=False),)


def save_as(state: AppState, go: Callable[[], None] | None = None) -> None:
    """The same by another name, which later ones go to; once it is saved, `go`."""

    def save_here(state: AppState, path: Path) -> None:
        state.session.after_saving = go
        save_to(state, path)

    if has_content(state):
        named = state.session.path or state.source.path
        name = named.stem if named is not None else UNNAMED
        actions.choose_path(state, "save", save_here, "session", f"{name}{SUFFIX}")


def has_content(state: AppState) -> bool:
    """There is something to keep: what is open, or, of a live source, what was written down."""
    return state.source.path is not None or has_case(state)


def has_case(state: AppState) -> bool:
    """Something has been written down, or collected for the case summary."""
    summary = state.summary
    return any((state.session.notes, summary.title, summary.notes, summary.items))


def _case(state: AppState) -> Case:
    return state.session.notes, _summary(state, state.places.config).substance


def keep_case(state: AppState) -> None:
    """The window stays after all, and with it the case that was to be discarded."""
    state.session.discarded = None


def loses_case(state: AppState) -> bool:
    """Notes or a case summary are in no session file, and nobody has given them up."""
    return has_case(state) and _case(state) not in (state.session.saved_case, state.session.discarded)


def leave_case(state: AppState, go: Callable[[], None]) -> None:
    """Go on with what ends the session and its case, after a question where they are in no file."""

    def on() -> None:
        if loses_case(state):
            state.session.leaving = go
        else:
            go()

    actions.leave_session(state, on)


def ask_new_case(state: AppState) -> None:
    """Whether notes and case summary shall begin anew, and in another file."""
    if has_case(state) and (loses_case(state) or look_for_changes(state)):
        state.session.leaving = partial(answer_new_case, state, agreed=True)
    else:
        state.session.asks_new_case = has_case(state)


def answer_new_case(state: AppState, *, agreed: bool) -> None:
    """Without notes and images of the case before; files that were saved stay, as they are."""
    state.session.asks_new_case = False
    if agreed:
        state.session.path, state.session.is_unsaved = None, False
        summary = state.summary
        state.session.notes = summary.title = summary.notes = ""
        # What is being saved is of the case before.
        summary.items, summary.awaited = (), ()
        # Undo leads back to none of them.
        enhancement_actions.rebase(state, [step.params for step in state.enhancement.past])


def save_to(state: AppState, path: Path) -> None:
    """From now on in this file."""
    state.session.path = path
    save(state)


def autosave_request(state: AppState) -> SessionRequest | None:
    """What has changed since it was last saved in passing, once in a while."""
    if not has_content(state) or state.window.now - state.session.autosaved_at < AUTOSAVE_SECONDS:
        return None
    state.session.autosaved_at = state.window.now
    path = autosave_path(state.places.config)
    session = snapshot(state, path.parent)
    _compare(state, session)
    if session == state.session.autosaved:
        return None
    state.session.autosaved = session
    return SessionRequest(path, session, in_passing=True)


def _compare(state: AppState, session: Session) -> None:
    state.session.is_unsaved = state.session.path is not None and session.substance != state.session.saved


def look_for_changes(state: AppState) -> bool:
    """Whether something is not in the session's file, as of this moment."""
    if state.session.path is not None:
        _compare(state, snapshot(state, state.session.path.parent))
    return state.session.is_unsaved


def answer(state: AppState, reply: str) -> None:
    """To "save the changes?": save, discard or stay."""
    kept = state.session
    go, kept.leaving = kept.leaving, None
    if go is None or reply == "stay":
        return
    if reply == "save" and kept.path is None:
        save_as(state, go)
        return
    if reply == "save":
        kept.after_saving = go
        save(state)
        return
    kept.discarded = _case(state)
    if kept.path is not None:
        kept.saved, kept.is_unsaved = snapshot(state, kept.path.parent).substance, False
    go()


def take_written(state: AppState, request: SessionRequest, answer: Path | Failure) -> None:
    """Say how it went; the same trouble with saving in passing is told once."""
    if request.in_passing:
        _autosaved(state, answer)
        return
    go, state.session.after_saving = state.session.after_saving, None
    if isinstance(answer, Failure):
        actions.fail(state, f"the session was not saved: {answer.message}")
        return
    state.session.saved_case = request.session.case
    if answer == state.session.path:
        state.session.saved, state.session.is_unsaved = request.session.substance, False
    actions.announce(state, f"saved {answer.name} in {located(answer.parent)}")
    actions.use_settings(state, state.settings.opened(answer))
    if go is not None:
        go()


def _autosaved(state: AppState, answer: Path | Failure) -> None:
    kept = state.session
    if not isinstance(answer, Failure):
        kept.autosave_trouble = ""
        return
    kept.autosaved = None
    if kept.autosave_trouble != answer.message:
        kept.autosave_trouble = answer.message
        actions.fail(state, f"the session cannot be autosaved: {answer.placed}")


def hides_model(state: AppState, opened: Opened) -> bool:
    """What the session shows gives way to another reconstruction that is in training."""
    run = state.runs.reconstruction
    if not run.is_alive or (opened.run is None and opened.splats is None):
        return False
    return opened.run is None or opened.run.path != run.run_path


def taken_up(state: AppState, opened: Opened, path: Path) -> None:
    """A session is open: one on disk is saved there again, unless that would leave out its reconstruction;
    one that a crash left is this process's now, where all of it is shown."""
    is_left, hides = path.parent == state.places.config, hides_model(state, opened)
    if is_left and not hides:
        with suppress(OSError):
            os.replace(path, autosave_path(state.places.config))
        return
    session, kept = snapshot(state, path.parent), state.session
    if not is_left:
        kept.saved_case = session.case
    if hides:
        waits = "is not shown while another is in training: open it again afterwards"
        actions.fail(
            state, f"the reconstruction of {path.name} {waits}; until then Save asks for another file"
        )
    else:
        kept.path, kept.saved = path, session.substance
