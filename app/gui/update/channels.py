"""The window's background work in one table: what is asked for, who answers, what takes the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Generic

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest, Pictures
from app.enhancement.methods import EnhancementSettings
from app.exports.exporting import ExportRequest, Step, export
from app.exports.window_shot import WindowRequest, save_window
from app.gui.actions import (
    actions,
    batch_actions,
    camera_actions,
    edit_actions,
    export_actions,
    job_actions,
    preset_actions,
    run_actions,
    session_actions,
    tuning_actions,
)
from app.gui.state.app_state import AppState
from app.gui.state.panes import difference_request
from app.gui.state.window import Wish
from app.gui.update import taking
from app.gui.update.at_rest import left_out_wish, strip_wish, thumbnails_wish, to_measure, to_tidy
from app.gui.update.bake_work import BakeWork
from app.gui.update.compare_work import CompareWork
from app.gui.update.opening_work import OpeningWork
from app.gui.update.queue_work import QueueWork
from app.gui.update.taking import told
from app.gui.update.view_wish import first_wish, second_wish
from app.gui.work.background import Answer, Channel, Failure, Request, SteppedChannel
from app.gui.work.batching import BatchRequest, Progressed, batch
from app.gui.work.clearing import clear_places
from app.gui.work.file_writing import WriteRequest, write_file
from app.gui.work.measuring import Measured, Measurer
from app.gui.work.omissions import Omissions, OmissionsRequest, look
from app.gui.work.picking import PickRequest, pick
from app.gui.work.presets import KeepPresets, keep_presets
from app.gui.work.run_list import FoundRuns, RunFinder, RunsRequest
from app.gui.work.run_models import Left, LeftRequest, ModelRequest, left_of, run_model
from app.gui.work.saving_edits import SavedEdits, SaveRequest, keep_edits
from app.gui.work.selecting import Selected, Selector, SelectRequest
from app.gui.work.session_writing import SessionRequest, write
from app.gui.work.settings import Places
from app.gui.work.strip import LeftOut, LeftOutRequest, Strip, StripRequest, left_out, make_strip
from app.gui.work.thumbnails import Thumbnails, ThumbnailsRequest, make_thumbnails
from app.gui.work.tidying import OnScreen, tidy
from app.gui.work.tuning import CellMaker, CellRequest, GridCell
from app.scenes.free_camera import Vector
from app.scenes.photos import Photo, PhotoRequest, read_photo
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest
from app.scenes.viewing import View, draw_view

NO_STRIP = "the clip's thumbnails cannot be shown"
NO_THUMBNAILS = "presets cannot be previewed"


@dataclass(frozen=True)
class Row(Generic[Request, Answer]):
    """One kind of work, from the wish for it to its answer."""

    channel: Channel[Request, Answer]
    take: Callable[[AppState, Request, Answer | Failure], None]
    wish: Callable[[AppState], Request | None] | None = None
    """What the state wishes for now; None where each request is asked for once, when it comes up."""
    forgets: bool = True
    """Without a wish, what was asked for is forgotten: it may be asked for again."""

    def answer(self, state: AppState) -> None:
        """Take what has been made since the last frame."""
        while (taken := self.channel.take()) is not None:
            self.take(state, *taken)

    def ask(self, state: AppState) -> None:
        """Ask for what is not there."""
        wanted = self.wish(state) if self.wish is not None else None
        if wanted is not None or (self.wish is not None and self.forgets):
            self.channel.want(wanted)


@dataclass
class Channels:
    """The kinds of background work; those with rules of their own, when to ask for what, are groups."""

    pictures: Channel[PictureRequest, Pictures] = field(default_factory=lambda: Channel(PictureMaker().make))
    picks: Channel[PickRequest, Vector | None] = field(default_factory=lambda: Channel(pick))
    selecting: Channel[SelectRequest, Selected] = field(default_factory=lambda: Channel(Selector().select))
    photos: Channel[PhotoRequest, Photo] = field(default_factory=lambda: Channel(read_photo))
    models: Channel[ModelRequest, Scene] = field(default_factory=lambda: Channel(run_model))
    left: Channel[LeftRequest, Left] = field(default_factory=lambda: Channel(left_of))
    view: Channel[ViewRequest, View] = field(default_factory=lambda: Channel(draw_view))
    second: Channel[ViewRequest, View] = field(default_factory=lambda: Channel(draw_view))
    saving: Channel[ExportRequest, Step] = field(default_factory=lambda: Channel(export, depth=16))
    windows: Channel[WindowRequest, Step] = field(default_factory=lambda: Channel(save_window, depth=4))
    cells: Channel[CellRequest, GridCell] = field(default_factory=lambda: Channel(CellMaker().make))
    sessions: Channel[SessionRequest, Path] = field(default_factory=lambda: Channel(write, depth=4))
    exports: SteppedChannel[ExportRequest, Step] = field(default_factory=lambda: SteppedChannel(export))
    batches: SteppedChannel[BatchRequest, Progressed] = field(default_factory=lambda: SteppedChannel(batch))
    omissions: Channel[OmissionsRequest, Omissions] = field(default_factory=lambda: Channel(look))
    runs: Channel[RunsRequest, FoundRuns] = field(default_factory=lambda: Channel(RunFinder().find))
    files: Channel[WriteRequest, Path] = field(default_factory=lambda: Channel(write_file, depth=256))
    presets: Channel[KeepPresets, dict[str, EnhancementSettings]] = field(
        default_factory=lambda: Channel(keep_presets, depth=64)
    )
    thumbnails: Channel[ThumbnailsRequest, Thumbnails] = field(
        default_factory=lambda: Channel(make_thumbnails)
    )
    edits: Channel[SaveRequest, SavedEdits] = field(default_factory=lambda: Channel(keep_edits))
    opening: OpeningWork = field(default_factory=OpeningWork)
    bakes: BakeWork = field(default_factory=BakeWork)
    compare: CompareWork = field(default_factory=CompareWork)
    measures: Channel[Pictures, Measured] = field(default_factory=lambda: Channel(Measurer().measure))
    strip: Channel[StripRequest, Strip] = field(default_factory=lambda: Channel(make_strip))
    left_out: Channel[LeftOutRequest, LeftOut] = field(default_factory=lambda: Channel(left_out))
    tidying: Channel[OnScreen, None] = field(default_factory=lambda: Channel(tidy))
    clearing: Channel[Places, None] = field(default_factory=lambda: Channel(clear_places))
    queue: QueueWork = field(default_factory=QueueWork)
    photo: Pictures | None = None
    """A photo whose enhanced partner is being made."""

    @cached_property
    def rows(self) -> Sequence[Row[Any, Any]]:
        """In the order in which answers are taken and wishes are asked for."""
        return (
            Row(self.models, told("the reconstruction cannot be shown", job_actions.take_model),
                lambda s: s.runs.model_wish),
            Row(self.left, told("what the run has left cannot be told", run_actions.take_left),
                lambda s: s.runs.reconstruction.ended),
            Row(self.picks, told("the point cannot be located", camera_actions.take_point),
                lambda s: s.scene.viewer.pick),
            Row(self.selecting, taking.take_selected, lambda s: s.editing.wish),
            Row(self.photos, told("the frame cannot be read", taking.take_photo), lambda s: s.photo_request),
            Row(self.omissions, told("what will be left out cannot be determined", taking.take_omissions),
                lambda s: s.omissions_request),
            Row(self.runs, run_actions.take_found, lambda s: s.runs_request),
            Row(self.view, taking.take_view, first_wish),
            Row(self.second, taking.take_second, second_wish),
            Row(self.cells, tuning_actions.take_cell, lambda s: s.tuning.request),
            Row(self.edits, edit_actions.take_saved, lambda s: s.editing.saving),
            Row(self.compare.difference, told("the difference cannot be shown", taking.take_difference),
                difference_request),
            Row(self.measures, told("the frame cannot be measured", taking.take_measured, actions.say),
                to_measure, forgets=False),
            Row(self.thumbnails, told(NO_THUMBNAILS, preset_actions.take_thumbnails, actions.say),
                thumbnails_wish, forgets=False),
            Row(self.strip, told(NO_STRIP, taking.take_strip, actions.say), strip_wish, forgets=False),
            Row(self.left_out, told(NO_STRIP, taking.take_left_out, actions.say), left_out_wish,
                forgets=False),
            Row(self.tidying, lambda *answered: None, to_tidy, forgets=False),
            Row(self.clearing, lambda *answered: None, lambda s: s.places),
            Row(self.saving, taking.take_saved),
            Row(self.windows, taking.take_saved),
            Row(self.sessions, session_actions.take_written),
            Row(self.exports, export_actions.take_step,
                lambda s: s.exports.under_way.request if s.exports.under_way is not None else None),
            Row(self.batches, batch_actions.take_progress, lambda s: s.batches.under_way),
            Row(self.files, taking.take_written),
            Row(self.presets, preset_actions.take_kept),
        )  # fmt: skip

    @property
    def keeping(self) -> Sequence[Channel[Any, Any]]:
        """What is not given up when the window closes."""
        return (self.files, self.presets, self.edits)

    @property
    def apart(self) -> Sequence[Channel[Any, Any]]:
        """What may never end, each request in a thread of its own: work without numba that opens files."""
        return (*self.opening.all, self.queue.clips)

    @property
    def beside(self) -> Sequence[Channel[Any, Any]]:
        """What a second worker does: work without numba, which no picture waits for."""
        first = (self.strip, self.left_out, self.measures, self.omissions, self.runs)
        return (*first, *self.keeping, *self.queue.all, self.tidying, self.clearing)

    @property
    def all(self) -> Sequence[Channel[Any, Any]]:
        """What the first worker does in turn, and what is apart."""
        first = (*self.opening.all, self.models, self.left, self.pictures, self.picks, self.selecting)
        views = (self.photos, *self.compare.all, self.view, self.second, *self.bakes.all)
        return (
            *first,
            *views,
            self.thumbnails,
            self.saving,
            self.windows,
            self.cells,
            self.sessions,
            self.exports,
            self.batches,
        )

    def ask_once(self, state: AppState) -> None:
        """Hand over what came up since the last frame."""
        wishes, state.window.wishes = state.window.wishes, ()
        channels: dict[type[Wish], Channel[Any, Any]] = {
            WriteRequest: self.files,
            KeepPresets: self.presets,
            SessionRequest: self.sessions,
            ExportRequest: self.saving,
        }
        for wish in wishes:
            channels[type(wish)].ask(wish)
        if (session := session_actions.autosave_request(state)) is not None:
            self.sessions.ask(session)

    def finish(self, state: AppState) -> None:
        """The window has closed and no worker is left: do what must not be given up."""
        self.ask_once(state)
        self.edits.want(state.editing.saving)
        for channel in self.keeping:
            while channel.run_waiting():
                pass
