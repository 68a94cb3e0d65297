"""The window's background work in one table: what is asked for, who answers, what takes the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Generic, Literal

import assets
from app.enhancement.clip_statistics import ClipMeasurer
from app.enhancement.frame_enhancer import PictureMaker, Pictures
from app.exports.comparison_images import OtherMaker, heat_map
from app.exports.exporting import ExportRequest, export
from app.gui.actions import (
    about_actions,
    actions,
    batch_actions,
    browse_actions,
    camera_actions,
    changing_runs,
    depth_actions,
    edit_actions,
    export_actions,
    guide_actions,
    job_actions,
    live_actions,
    masking_actions,
    preset_actions,
    queue_actions,
    run_actions,
    second_actions,
    session_actions,
    summary_actions,
    sweep_actions,
    tuning_actions,
)
from app.gui.state.app_state import AppState
from app.gui.state.panes import difference_request
from app.gui.state.window import Wish
from app.gui.update import taking, wishes
from app.gui.update.patience import Patience
from app.gui.update.taking import noted, told
from app.gui.views.comparison import SIDES
from app.gui.work.about import read_about
from app.gui.work.background import Answer, Channel, Failure, NewestChannel, Request, SteppedChannel
from app.gui.work.baking import bake
from app.gui.work.batching import batch
from app.gui.work.beside import find_models
from app.gui.work.changing_runs import ChangeRequest, change_run, measure_folder
from app.gui.work.clip_scale import find_scale
from app.gui.work.depths import find_ways, read_depth
from app.gui.work.keeping import KeepClip, KeepSettings, SettingsKeeper, keep_clip
from app.gui.work.kept_layout import seal_anew
from app.gui.work.listing import list_folder, thumbnail_of
from app.gui.work.live_devices import find_devices
from app.gui.work.masking import (
    KeepMask,
    grow,
    keep_mask,
    left_out,
    look_for_masks,
    make_all,
    read_frame_mask,
)
from app.gui.work.measuring import Measurer
from app.gui.work.naming import encoder_of, name_of
from app.gui.work.neighbours import find_neighbours
from app.gui.work.omissions import find_omissions
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.presets import KeepPresets, keep_presets
from app.gui.work.queued_clips import QueuedClipRequest, open_queued
from app.gui.work.recents import find_recents
from app.gui.work.revealing import RevealRequest, reveal
from app.gui.work.run_measures import measure_run
from app.gui.work.runs import RunFinder, left_of, run_model
from app.gui.work.saving_edits import keep_edits
from app.gui.work.selecting import Selector, pick
from app.gui.work.shipped import read_guide, read_welcome
from app.gui.work.strip import make_strip
from app.gui.work.swept import read_swept_image
from app.gui.work.thumbnails import make_thumbnails
from app.gui.work.tidying import clear_places, clear_results
from app.gui.work.tuning import CellMaker
from app.gui.work.writing import SessionRequest, WriteRequest, save_queue, save_session, write_file
from app.scenes.drawer import draw_view
from app.scenes.scene import Scene
from app.scenes.view_request import read_frame

Server = Literal["first", "second", "third", "apart"]
"""The first worker, which pictures wait for; the second, for work that no picture waits for, without kernels
that have threads of their own; the third, for work of many seconds at a time, which nothing that is saved is
to wait for: it has such kernels, too. Or a thread of its own for each request: what opens files, without
numba, may never end."""
SECOND: Final = "second"
THIRD: Final = "third"


@dataclass(frozen=True)
class Row(Generic[Request, Answer]):
    """One kind of work, from the wish for it to its answer."""

    channel: Channel[Request, Answer]
    take: Callable[[AppState, Request, Answer | Failure], None]
    wish: Callable[[AppState], Request | None] | None = None
    """What the state wishes for now; None where each request is asked for once, when it comes up."""
    server: Server = "first"
    forgets: bool = True
    """Without a wish, what was asked for is forgotten: it may be asked for again."""
    patience: Patience | None = None
    """With what may take long."""

    def answer(self, state: AppState) -> None:
        """Take what has been made since the last frame."""
        while (taken := self.channel.take()) is not None:
            self.take(state, *taken)

    def ask(self, state: AppState) -> None:
        """Ask for what is not there."""
        wanted = self.wish(state) if self.wish is not None else None
        if wanted is not None or (self.wish is not None and self.forgets):
            self.channel.want(wanted)
        if self.patience is not None:
            self.patience.follow(state, wanted)


class Channels:
    """The kinds of background work: each with when it is asked for, and who takes what it makes.

    The pictures have rules of their own for that: see `update`.
    """

    # fmt: off
    def __init__(self) -> None:
        self.rows: list[Row[Any, Any]] = []
        """In the order in which answers are taken and wishes are asked for."""
        self.pictures = Channel(PictureMaker().make)
        self.original: Pictures | None = None
        """Of a frame whose enhanced partner is not there yet."""
        row = self._row
        self.opening = row(NewestChannel(open_path), taking.take_opened, lambda s: s.source.opening, "apart",
                           patience=Patience(_still_waiting))
        self.second_opening = row(NewestChannel(open_path), second_actions.take_second,
                                  lambda s: s.scene.second.opening, "apart",
                                  patience=Patience(_still_waiting))
        self.clips = row(NewestChannel(open_queued), queue_actions.take_clip, wishes.clip_wish, "apart",
                         forgets=False, patience=Patience(_waits_for_clip, can_stop=False))
        self.ways = row(NewestChannel(find_ways),
                        noted("possible sources of depth cannot be listed", depth_actions.take_ways),
                        wishes.ways_wish, "apart")
        self.neighbours = row(NewestChannel(find_neighbours),
                              noted("the images beside this one cannot be listed", taking.take_neighbours),
                              wishes.neighbours_wish, "apart")
        self.depths = row(NewestChannel(read_depth), depth_actions.take_depth, lambda s: s.source.depth_wish,
                          "apart")
        others = OtherMaker()  # What one side remembers serves the other.
        self.others = {side: row(Channel(others.make), partial(taking.take_other, side),
                                 partial(wishes.side_wish, side=side), forgets=False) for side in SIDES}
        self.kept = row(Channel(save_queue), noted("the queue cannot be saved", taking.take_nothing),
                        wishes.queue_wish, SECOND)
        self.layouts = row(Channel(seal_anew), taking.take_nothing, wishes.layout_wish, SECOND, forgets=False)
        self.bakes = row(Channel(bake), taking.take_baked, lambda s: wishes.bake_wish(s, s.scene))
        self.second_bakes = row(Channel(bake), taking.take_second_baked,
                                lambda s: wishes.bake_wish(s, s.scene.second))
        self.shown = row(SteppedChannel(Scene.find_shown), taking.take_nothing,
                         lambda s: wishes.shown_wish(s, s.scene))
        self.second_shown = row(SteppedChannel(Scene.find_shown), taking.take_nothing,
                                lambda s: wishes.shown_wish(s, s.scene.second))
        self.scales = row(Channel(find_scale),
                          noted("the view has no scale for the whole clip", taking.take_scale),
                          wishes.scale_wish, forgets=False)
        self.models = row(Channel(run_model),
                          told("the reconstruction cannot be shown", job_actions.take_model),
                          job_actions.model_wish)
        self.left = row(Channel(left_of),
                        told("what is left of the run cannot be read", run_actions.take_left),
                        lambda s: s.runs.reconstruction.ended)
        self.picks = row(Channel(pick), told("the point cannot be located", camera_actions.take_point),
                         lambda s: s.scene.viewer.pick)
        self.selecting = row(Channel(Selector().select), edit_actions.take_selected, lambda s: s.editing.wish)
        self.frames = row(Channel(read_frame), told("the frame cannot be read", taking.take_frame),
                          lambda s: s.frame_request)
        self.omissions = row(Channel(find_omissions), taking.take_omissions, lambda s: s.omissions_request,
                             THIRD)
        self.masks_there = row(Channel(look_for_masks),
                               noted("tool masks cannot be listed", masking_actions.take_there),
                               masking_actions.there_wish, SECOND)
        self.frame_masks = row(NewestChannel(read_frame_mask),
                               told("the tools of this frame cannot be shown", masking_actions.take_mask),
                               masking_actions.mask_wish, "apart")
        self.grows = row(NewestChannel(grow), masking_actions.take_grown, lambda s: s.masking.growing,
                         "apart")
        self.made_masks = row(SteppedChannel(make_all), masking_actions.take_made, lambda s: s.masking.making,
                              SECOND)
        self.kept_masks = row(Channel(keep_mask, depth=256), masking_actions.take_kept, server=SECOND)
        self.runs = row(Channel(RunFinder().find), run_actions.take_found, lambda s: s.runs_request, SECOND)
        self.beside = row(Channel(find_models),
                          noted("models for a second view cannot be listed", second_actions.take_models),
                          wishes.models_wish, SECOND)
        self.view = row(Channel(draw_view), taking.take_view, wishes.view_wish)
        self.second = row(Channel(draw_view), taking.take_second, wishes.second_wish)
        self.cells = row(Channel(CellMaker().make), tuning_actions.take_cell, wishes.cell_wish)
        self.edits = row(Channel(keep_edits), edit_actions.take_saved, lambda s: s.editing.saving, SECOND)
        self.difference = row(Channel(heat_map),
                              told("the difference cannot be shown", taking.take_difference),
                              difference_request)
        self.measures = row(Channel(Measurer().measure),
                            noted("the frame cannot be measured", taking.take_measured), wishes.measure_wish,
                            THIRD, forgets=False)
        self.run_measures = row(SteppedChannel(measure_run), taking.take_run_measures,
                                wishes.run_measures_wish, forgets=False)
        self.statistics = row(SteppedChannel(ClipMeasurer().measure), taking.take_statistics,
                              wishes.statistics_wish)
        self.thumbnails = row(Channel(make_thumbnails),
                              noted("presets cannot be previewed", preset_actions.take_thumbnails),
                              wishes.thumbnails_wish, forgets=False)
        self.strip = row(Channel(make_strip),
                         noted("the clip's thumbnails cannot be shown", taking.take_strip), wishes.strip_wish,
                         SECOND, forgets=False)
        self.left_out = row(Channel(left_out),
                            noted("areas left out of this frame cannot be shown", taking.take_left_out),
                            wishes.left_out_wish, SECOND, forgets=False)
        self.recents = row(Channel(find_recents), noted("recent files cannot be shown", taking.take_recents),
                           wishes.recents_wish, "apart", forgets=False)
        self.job_images = row(Channel(read_swept_image), sweep_actions.take_image, lambda s: s.reports.job,
                              "apart")
        self.welcome = row(Channel(read_welcome),
                           noted("the first page cannot be shown", taking.take_welcome),
                           lambda s: assets.welcome_path() if s.is_empty else None, SECOND, forgets=False)
        self.guide = row(Channel(read_guide), told("the guide cannot be shown", guide_actions.take_guide),
                         lambda s: assets.guide_path() if s.guide.shown else None, SECOND, forgets=False)
        self.about = row(Channel(read_about), told("the versions cannot be listed", about_actions.take_about),
                         lambda s: s.scene.drawn_by if s.about.shown else None, SECOND, forgets=False)
        self.clearing = row(Channel(clear_places), taking.take_nothing, lambda s: s.places, SECOND)
        self.clearing_results = row(Channel(clear_results), taking.take_nothing, wishes.results_wish, "apart")
        self.saving = row(Channel(export, depth=2 * export_actions.MOST_SAVING), summary_actions.take_saved)
        self.summary_pictures = row(NewestChannel(thumbnail_of), summary_actions.take_thumbnail,
                                    summary_actions.thumbnail_wish, "apart")
        self.sessions = row(Channel(save_session, depth=4), session_actions.take_written, server=SECOND)
        self.autosaves = row(Channel(save_session), session_actions.take_written, server=SECOND)
        self.exports = row(SteppedChannel(export), export_actions.take_step, lambda s: s.exports.under_way)
        # So deep, a failure leaves the step before it, which tells what is whole.
        self.batches = row(SteppedChannel(batch, depth=2), batch_actions.take_progress,
                           lambda s: s.batches.under_way)
        self.listing = row(NewestChannel(list_folder), browse_actions.take_listing, browse_actions.list_wish,
                           "apart")
        self.small_files = row(NewestChannel(thumbnail_of), browse_actions.take_thumbnail,
                               browse_actions.thumbnail_wish, "apart")
        self.names = row(NewestChannel(name_of), export_actions.take_name, export_actions.name_wish, "apart")
        self.encoders = row(Channel(encoder_of), export_actions.take_encoder, export_actions.encoder_wish,
                            "apart", forgets=False)
        self.devices = row(NewestChannel(find_devices), live_actions.take_devices, live_actions.devices_wish,
                           "apart")
        self.reveals = row(Channel(reveal, depth=4), export_actions.take_revealed, server="apart")
        self.changes = row(Channel(change_run, depth=8), changing_runs.take_changed, server=SECOND)
        self.footprints = row(Channel(measure_folder),
                              told("the folder cannot be measured", changing_runs.take_footprint),
                              changing_runs.footprint_wish, SECOND)
        self.files = row(Channel(write_file, depth=256), taking.take_written, server=SECOND)
        self.settings = row(Channel(SettingsKeeper().keep, depth=64),
                            noted("settings cannot be saved", actions.take_settings), server=SECOND)
        self.known = row(Channel(keep_clip, depth=256),
                         noted("the clip's settings cannot be saved", taking.take_nothing), server=SECOND)
        self.presets = row(Channel(keep_presets, depth=64), preset_actions.take_kept, server=SECOND)
    # fmt: on

    def _row(
        self,
        channel: Channel[Request, Answer],
        take: Callable[[AppState, Request, Answer | Failure], None],
        wish: Callable[[AppState], Request | None] | None = None,
        server: Server = "first",
        *,
        forgets: bool = True,
        patience: Patience | None = None,
    ) -> Channel[Request, Answer]:
        """One kind of work: see Row."""
        self.rows.append(Row(channel, take, wish, server, forgets, patience))
        return channel

    def of(self, server: Server) -> Sequence[Channel[Any, Any]]:
        """What it serves, in turn."""
        found = tuple(row.channel for row in self.rows if row.server == server)
        return (self.pictures, *found) if server == "first" else found

    def ask_once(self, state: AppState) -> None:
        """Hand over what came up since the last frame."""
        wishes, state.window.wishes = state.window.wishes, ()
        channels: dict[type[Wish], Channel[Any, Any]] = {
            WriteRequest: self.files,
            KeepSettings: self.settings,
            KeepClip: self.known,
            KeepPresets: self.presets,
            SessionRequest: self.sessions,
            ExportRequest: self.saving,
            RevealRequest: self.reveals,
            ChangeRequest: self.changes,
            KeepMask: self.kept_masks,
        }
        for wish in wishes:
            channels[type(wish)].ask(wish)
        if (session := session_actions.autosave_request(state)) is not None:
            self.autosaves.ask(session)

    def finish(self, state: AppState) -> None:
        """The window has closed and no worker is left: do what must not be given up."""
        masking_actions.end_stroke(state)  # The button may still be held.
        self.ask_once(state)
        self.edits.want(state.editing.saving)
        for channel in (self.files, self.settings, self.known, self.presets, self.edits, self.kept_masks):
            while channel.run_waiting():
                pass


def _still_waiting(request: OpenRequest) -> str:
    return f"still waiting for {request.path}"


def _waits_for_clip(wanted: QueuedClipRequest) -> str:
    return f"{wanted.request.run_path.name} waits for its clip {wanted.request.clip_path}"
