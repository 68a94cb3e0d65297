"""Once a frame, before drawing: take what background work has finished, ask for what the state now needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest, Pictures
from app.exports.exporting import ExportRequest, Step, export
from app.exports.window_shot import WindowRequest, save_window
from app.gui.actions import (
    actions,
    batch_actions,
    camera_actions,
    edit_actions,
    export_actions,
    path_actions,
    run_actions,
    session_actions,
    tuning_actions,
)
from app.gui.state.app_state import AppState
from app.gui.update.answered import answered
from app.gui.update.bake_work import BakeWork
from app.gui.update.compare_work import CompareWork
from app.gui.update.job_events import follow_job
from app.gui.update.job_work import JobWork
from app.gui.update.keep_work import KeepWork
from app.gui.update.measure_work import MeasureWork
from app.gui.update.memory_work import MemoryWork
from app.gui.update.opening_work import OpeningWork
from app.gui.update.queue_work import QueueWork
from app.gui.update.strip_work import StripWork
from app.gui.work.background import Channel, Failure, SteppedChannel
from app.gui.work.batching import BatchRequest, Progressed, batch
from app.gui.work.omissions import Omissions, OmissionsRequest, look
from app.gui.work.picking import Picked, PickRequest, pick
from app.gui.work.run_list import FoundRuns, RunFinder, RunsRequest
from app.gui.work.selecting import Selected, Selector, SelectRequest
from app.gui.work.session_writing import SessionRequest, write
from app.gui.work.tuning import CellMaker, CellRequest, GridCell
from app.scenes.photos import Photo, PhotoRequest, read_photo
from app.scenes.view_request import ViewRequest
from app.scenes.view_selection import FRAMES_PER_SECOND
from app.scenes.viewing import View, draw_view

PROMPT = 0.012
"""Seconds that a frame waits for a picture after a setting has moved: most come in less, and are shown in the
frame that moved it."""
PATIENCE = 0.3
"""Seconds before a new frame's photo is shown without its enhanced partner."""
SLOW_VIEW = 60.0
"""Milliseconds above which the 3D view is drawn smaller while it moves."""
REDUCED = 0.5


@dataclass
class Channels:
    """The kinds of background work, in the order in which the worker serves them."""

    opening: OpeningWork = field(default_factory=OpeningWork)
    pictures: Channel[PictureRequest, Pictures] = field(default_factory=lambda: Channel(PictureMaker().make))
    picks: Channel[PickRequest, Picked] = field(default_factory=lambda: Channel(pick))
    selecting: Channel[SelectRequest, Selected] = field(default_factory=lambda: Channel(Selector().select))
    photos: Channel[PhotoRequest, Photo] = field(default_factory=lambda: Channel(read_photo))
    view: Channel[ViewRequest, View] = field(default_factory=lambda: Channel(draw_view))
    second: Channel[ViewRequest, View] = field(default_factory=lambda: Channel(draw_view))
    bakes: BakeWork = field(default_factory=BakeWork)
    saving: Channel[ExportRequest, Step] = field(default_factory=lambda: Channel(export, depth=16))
    windows: Channel[WindowRequest, Step] = field(default_factory=lambda: Channel(save_window, depth=4))
    cells: Channel[CellRequest, GridCell] = field(default_factory=lambda: Channel(CellMaker().make))
    compare: CompareWork = field(default_factory=CompareWork)
    sessions: Channel[SessionRequest, Path] = field(default_factory=lambda: Channel(write, depth=4))
    omissions: Channel[OmissionsRequest, Omissions] = field(default_factory=lambda: Channel(look))
    measure: MeasureWork = field(default_factory=MeasureWork)
    runs: Channel[RunsRequest, FoundRuns] = field(default_factory=lambda: Channel(RunFinder().find))
    exports: SteppedChannel[ExportRequest, Step] = field(default_factory=lambda: SteppedChannel(export))
    batches: SteppedChannel[BatchRequest, Progressed] = field(default_factory=lambda: SteppedChannel(batch))
    strip: StripWork = field(default_factory=StripWork)
    job: JobWork = field(default_factory=JobWork)
    queue: QueueWork = field(default_factory=QueueWork)
    keep: KeepWork = field(default_factory=KeepWork)
    memory: MemoryWork = field(default_factory=MemoryWork)
    photo: Pictures | None = None
    """A photo whose enhanced partner is being made."""

    @property
    def apart(self) -> Sequence[Channel[Any, Any]]:
        """What may never end, each request in a thread of its own: work without numba that opens files."""
        return (*self.opening.all, self.queue.clips)

    @property
    def beside(self) -> Sequence[Channel[Any, Any]]:
        """What a second worker does: work without numba, which no picture waits for."""
        return (
            *self.measure.all,
            *self.strip.all,
            self.omissions,
            self.runs,
            *self.keep.all,
            *self.queue.all,
            *self.memory.all,
        )

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        first = (*self.opening.all, *self.job.all, self.pictures, self.picks, self.selecting, self.photos)
        views = (self.view, self.second)
        last = (self.saving, self.windows, self.cells, self.sessions, self.exports, self.batches)
        return (*first, *self.compare.all, *views, *self.bakes.all, *last)


def update(state: AppState, channels: Channels, now: float) -> None:
    """Advance to `now`, seconds on the window's clock."""
    elapsed, state.window.now = now - state.window.now, now
    if state.window.toast is not None and now > state.window.toast.until:
        state.window.toast = None
    channels.opening.take(state)
    take_pictures(state, channels)
    _take_pick(state, channels)
    _take_photo(state, channels)
    channels.compare.take(state)
    channels.measure.take(state)
    channels.strip.take(state)
    channels.queue.take(state)
    channels.keep.take(state)
    _take_omissions(state, channels)
    if (found := channels.runs.take()) is not None:
        run_actions.take_found(state, found[1])
    edit_actions.follow(state)
    _take_selected(state, channels)
    _take_view(state, channels)
    _take_second(state, channels)
    channels.bakes.take(state)
    _take_saved(state, channels)
    _take_cell(state, channels)
    _take_written(state, channels)
    _take_step(state, channels)
    follow_job(state)
    channels.job.take(state)
    _play(state, elapsed)
    path_actions.advance_path(state, elapsed)
    _ask(state, channels)


def _ask_for_pictures(state: AppState, channels: Channels) -> bool:
    """Before answers are taken, for a setting that has moved, and at the end, for a frame that plays. Whether
    these had not been asked for before."""
    pictures = state.picture_request
    if pictures is None or channels.pictures.asked == pictures:
        return False
    state.picture.asked_at = state.window.now
    channels.pictures.ask(pictures)
    return True


def take_pictures(state: AppState, channels: Channels) -> None:
    """Those of a setting that has just moved too, where they come soon: before a frame and within it."""
    if _ask_for_pictures(state, channels) and _may_come_at_once(state):
        channels.pictures.wait(PROMPT)
    taken = channels.pictures.take()
    if taken is not None and taken[0].clip is state.source.clip:
        request, answer = taken
        if isinstance(answer, Pictures):
            channels.photo = answer
        elif request == state.picture_request:
            state.timeline.playing = False
            actions.fail(state, answer.message)
    if channels.photo is not None and _may_show(state, channels.photo):
        state.picture.pictures, channels.photo = channels.photo, None


def _may_come_at_once(state: AppState) -> bool:
    """Another setting for the frame on screen, where the last one took little time."""
    shown, request = state.picture.pictures, state.picture_request
    if shown is None or shown.enhanced is None or request is None or shown.request == request:
        return False
    same = replace(shown.request, params=None) == replace(request, params=None)
    return same and request.params is not None and shown.milliseconds < 1000 * PROMPT


def _may_show(state: AppState, pictures: Pictures) -> bool:
    """A photo and its enhanced partner appear together; alone only where it would be long in coming."""
    if pictures.request.clip is not state.source.clip:
        return False
    if pictures.enhanced is not None or pictures.request.params is None or state.picture.pictures is None:
        return True
    same_frame = state.picture.pictures.request.frame_index == pictures.request.frame_index
    return not same_frame and state.window.now - state.picture.asked_at > PATIENCE


def _take_pick(state: AppState, channels: Channels) -> None:
    if (taken := answered(state, channels.picks, "the point cannot be located")) is not None:
        camera_actions.take_point(state, *taken)


def _take_omissions(state: AppState, channels: Channels) -> None:
    if (
        taken := answered(state, channels.omissions, "what will be left out cannot be determined")
    ) is not None:
        state.runs.omissions = taken[1]


def _take_selected(state: AppState, channels: Channels) -> None:
    taken = channels.selecting.take()
    if taken is None:
        return
    request, answer = taken
    if isinstance(answer, Failure):
        state.editing.wish = None
        actions.fail(state, f"nothing was selected: {answer.message}")
    else:
        edit_actions.take_selected(state, request, answer)


def _take_photo(state: AppState, channels: Channels) -> None:
    if (taken := answered(state, channels.photos, "the frame cannot be read")) is not None:
        state.scene.viewer.photo = taken[1]


def _take_view(state: AppState, channels: Channels) -> None:
    taken = channels.view.take()
    if taken is None or state.scene.model is None:
        return
    if isinstance(taken[1], Failure):
        actions.fail(state, f"the 3D view cannot be rendered: {taken[1].message}")
    else:
        state.scene.view = taken[1]


def _take_second(state: AppState, channels: Channels) -> None:
    drawn = channels.second.take()
    if drawn is None or drawn[0].scene is not state.scene.second.shown:
        return
    if isinstance(drawn[1], Failure):
        actions.fail(state, f"the second 3D view cannot be rendered: {drawn[1].message}")
    else:
        state.scene.second.view = drawn[1]


def _take_saved(state: AppState, channels: Channels) -> None:
    while (taken := channels.saving.take()) is not None:
        export_actions.take_saved(state, taken[1])
    while (window := channels.windows.take()) is not None:
        export_actions.take_saved(state, window[1])


def _take_cell(state: AppState, channels: Channels) -> None:
    if (taken := channels.cells.take()) is not None:
        tuning_actions.take_cell(state, *taken)


def _take_written(state: AppState, channels: Channels) -> None:
    while (taken := channels.sessions.take()) is not None:
        session_actions.take_written(state, *taken)


def _take_step(state: AppState, channels: Channels) -> None:
    while (taken := channels.exports.take()) is not None:
        export_actions.take_step(state, *taken)
    while (progressed := channels.batches.take()) is not None:
        batch_actions.take_progress(state, *progressed)


def _play(state: AppState, elapsed: float) -> None:
    """Time goes on only when what it needs is on screen: a slow machine plays slower, never out of step."""
    if not state.timeline.playing or state.source.clip is None or _waits(state):
        return
    rate = state.source.clip.frames_per_second or FRAMES_PER_SECOND
    first, last = state.source.span
    onward = state.timeline.playhead + min(elapsed, 0.25) * rate
    within = first <= state.timeline.playhead < last + 1
    state.timeline.playhead = first + (onward - first) % (last + 1 - first) if within else float(first)
    state.timeline.frame_index = int(state.timeline.playhead)


def _waits(state: AppState) -> bool:
    return state.timeline.frozen_index is None and state.pictures_wait


def view_request(state: AppState) -> ViewRequest | None:
    """What the 3D view should show, smaller while it moves when a whole one takes long."""
    request = state.view_request
    moving = (
        state.scene.dragged
        or state.scene.viewer.moving
        or state.timeline.playing
        or state.scene.cameras.playing
    )
    if request is None or not moving or not is_slow(state.scene.view, state.scene.second.view):
        return request
    return request.scaled(REDUCED)


def is_slow(*views: View | None) -> bool:
    """Whether the last pictures together would have taken long at full size."""
    shares = [(view.milliseconds, view.request.reduced) for view in views if view is not None]
    return sum(spent / REDUCED**2 if reduced else spent for spent, reduced in shares) > SLOW_VIEW


def _ask(state: AppState, channels: Channels) -> None:
    channels.opening.ask(state)
    _ask_for_pictures(state, channels)
    channels.picks.want(state.scene.viewer.pick)
    channels.selecting.want(state.editing.wish)
    channels.photos.want(state.photo_request)
    channels.bakes.ask(state)
    channels.cells.want(state.tuning.request)
    if (session := session_actions.autosave_request(state)) is not None:
        channels.sessions.ask(session)
    channels.compare.ask(state)
    channels.measure.ask(state)
    channels.strip.ask(state)
    channels.queue.ask(state)
    channels.job.ask(state)
    channels.keep.ask(state)
    channels.memory.ask(state)
    channels.runs.want(state.runs_request)
    state.runs.is_listed = False
    channels.omissions.want(state.omissions_request)
    view = view_request(state)
    channels.view.want(view if state.scene.processor_draws else None)
    _ask_second(state, channels, view)


def _ask_second(state: AppState, channels: Channels, first: ViewRequest | None) -> None:
    """The second 3D view is of the first one's moment, camera and size."""
    channels.second.want(
        state.scene.beside(first) if first is not None and state.scene.processor_draws else None
    )
