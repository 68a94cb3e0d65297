"""The window's background work in one table: what is asked for, who answers, what takes the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
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
from app.gui.update.taking import told
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
from app.gui.work.omissions import look
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.presets import KeepPresets, keep_presets
from app.gui.work.recents import find_recents
from app.gui.work.revealing import RevealRequest, reveal
from app.gui.work.run_measures import measure_run
from app.gui.work.runs import RunFinder, left_of, run_model
from app.gui.work.saving_edits import keep_edits
from app.gui.work.selecting import Selector, pick
from app.gui.work.shipped import read_guide, read_welcome
from app.gui.work.strip import make_strip
from app.gui.work.swept import read_swept_image
from app.gui.work.taking_up import TakeUpRequest, take_up
from app.gui.work.thumbnails import make_thumbnails
from app.gui.work.tidying import clear_places, clear_results
from app.gui.work.tuning import CellMaker
from app.gui.work.writing import SessionRequest, WriteRequest, keep, write, write_file
from app.scenes.drawer import draw_view
from app.scenes.view_request import read_frame

Server = Literal["first", "second", "apart"]
"""The first worker, with numba, which pictures wait for; the second, for work without numba that no picture
waits for; or a thread of its own for each request: what opens files, without numba, may never end."""
SECOND: Final = "second"
NO_STRIP = "the clip's thumbnails cannot be shown"
NO_TINT = "what is left out of this frame cannot be shown"
NO_MODELS = "what can be seen in a second view cannot be told"
NO_NEIGHBOURS = "the images beside this one cannot be listed"
NO_MASKS = "tool masks cannot be listed"
NO_MASK = "the tools of this frame cannot be shown"
NO_WAYS = "where depth can come from cannot be told"
NO_THUMBNAILS = "presets cannot be previewed"


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
    """The kinds of background work, by name; `rows` says when each is asked for, and who takes what it makes.

    The pictures have rules of their own for that: see `update`.
    """

    def __init__(self) -> None:
        self.pictures = Channel(PictureMaker().make)
        self.original: Pictures | None = None
        """Of a frame whose enhanced partner is not there yet."""
        self.opening = NewestChannel(open_path)
        self.second_opening = NewestChannel(open_path)
        self.clips = NewestChannel(take_up)
        self.ways, self.depths = NewestChannel(find_ways), NewestChannel(read_depth)
        self.neighbours = NewestChannel(find_neighbours)
        self.models, self.left = Channel(run_model), Channel(left_of)
        self.picks, self.selecting = Channel(pick), Channel(Selector().select)
        self.frames = Channel(read_frame)
        others = OtherMaker()  # What one side remembers serves the other.
        self.others = {side: Channel(others.make) for side in SIDES}
        self.difference = Channel(heat_map)
        self.view, self.second = Channel(draw_view), Channel(draw_view)
        self.bakes, self.second_bakes = Channel(bake), Channel(bake)
        self.scales = Channel(find_scale)
        self.statistics = SteppedChannel(ClipMeasurer().measure)
        self.thumbnails = Channel(make_thumbnails)
        self.saving = Channel(export, depth=2 * export_actions.MOST_SAVING)
        self.cells = Channel(CellMaker().make)
        self.sessions, self.autosaves = Channel(write, depth=4), Channel(write)
        self.exports = SteppedChannel(export)
        # So deep, a failure leaves the step before it, which tells what is whole.
        self.batches = SteppedChannel(batch, depth=2)
        self.strip, self.left_out = Channel(make_strip), Channel(left_out)
        self.measures = Channel(Measurer().measure)
        self.omissions = Channel(look)
        self.masks_there, self.frame_masks = Channel(look_for_masks), NewestChannel(read_frame_mask)
        self.grows, self.made_masks = NewestChannel(grow), SteppedChannel(make_all)
        self.kept_masks = Channel(keep_mask, depth=256)
        self.run_measures = SteppedChannel(measure_run)
        self.runs, self.beside = Channel(RunFinder().find), Channel(find_models)
        self.changes, self.footprints = Channel(change_run, depth=8), Channel(measure_folder)
        self.files = Channel(write_file, depth=256)
        self.settings, self.known = Channel(SettingsKeeper().keep, depth=64), Channel(keep_clip, depth=256)
        self.presets = Channel(keep_presets, depth=64)
        self.edits = Channel(keep_edits)
        self.kept, self.layouts = Channel(keep), Channel(seal_anew)
        self.recents, self.job_images = Channel(find_recents), Channel(read_swept_image)
        self.welcome, self.guide = Channel(read_welcome), Channel(read_guide)
        self.about = Channel(read_about)
        self.listing, self.small_files = NewestChannel(list_folder), NewestChannel(thumbnail_of)
        self.summary_pictures = NewestChannel(thumbnail_of)
        self.names, self.encoders = NewestChannel(name_of), Channel(encoder_of)
        self.reveals = Channel(reveal, depth=4)
        self.devices = NewestChannel(find_devices)
        self.clearing, self.clearing_results = Channel(clear_places), Channel(clear_results)

    @cached_property
    def rows(self) -> Sequence[Row[Any, Any]]:
        """In the order in which answers are taken and wishes are asked for."""
        return (
            Row(self.opening, taking.take_opened, lambda s: s.source.opening, "apart",
                patience=Patience(_still_waiting)),
            Row(self.second_opening, second_actions.take_second, lambda s: s.scene.second.opening, "apart",
                patience=Patience(_still_waiting)),
            Row(self.clips, queue_actions.take_clip, wishes.clip_wish, "apart", forgets=False,
                patience=Patience(_waits_for_clip, can_stop=False)),
            Row(self.ways, told(NO_WAYS, depth_actions.take_ways, actions.say),
                wishes.ways_wish, "apart"),
            Row(self.neighbours, told(NO_NEIGHBOURS, taking.take_neighbours, actions.say),
                wishes.neighbours_wish, "apart"),
            Row(self.depths, depth_actions.take_depth, lambda s: s.source.depth_wish, "apart"),
            *(Row(channel, partial(taking.take_other, side), partial(wishes.side_wish, side=side),
                  forgets=False) for side, channel in self.others.items()),
            Row(self.kept, told("the queue cannot be saved", taking.take_nothing, actions.say),
                wishes.queue_wish, SECOND),
            Row(self.layouts, taking.take_nothing, wishes.layout_wish, SECOND, forgets=False),
            Row(self.bakes, taking.take_baked, lambda s: wishes.bake_wish(s, s.scene)),
            Row(self.second_bakes, taking.take_second_baked, lambda s: wishes.bake_wish(s, s.scene.second)),
            Row(self.scales, told("the view has no scale for the whole clip", taking.take_scale, actions.say),
                wishes.scale_wish, forgets=False),
            Row(self.models, told("the reconstruction cannot be shown", job_actions.take_model),
                job_actions.model_wish),
            Row(self.left, told("what the run has left cannot be told", run_actions.take_left),
                lambda s: s.runs.reconstruction.ended),
            Row(self.picks, told("the point cannot be located", camera_actions.take_point),
                lambda s: s.scene.viewer.pick),
            Row(self.selecting, edit_actions.take_selected, lambda s: s.editing.wish),
            Row(self.frames, told("the frame cannot be read", taking.take_frame), lambda s: s.frame_request),
            Row(self.omissions, told("what will be left out cannot be determined", taking.take_omissions),
                lambda s: s.omissions_request, SECOND),
            Row(self.masks_there, told(NO_MASKS, masking_actions.take_there, actions.say),
                masking_actions.there_wish, SECOND),
            Row(self.frame_masks, told(NO_MASK, masking_actions.take_mask), masking_actions.mask_wish,
                "apart"),
            Row(self.grows, masking_actions.take_grown, lambda s: s.masking.growing, "apart"),
            Row(self.made_masks, masking_actions.take_made, lambda s: s.masking.making, SECOND),
            Row(self.kept_masks, masking_actions.take_kept, server=SECOND),
            Row(self.runs, run_actions.take_found, lambda s: s.runs_request, SECOND),
            Row(self.beside, told(NO_MODELS, second_actions.take_models, actions.say), wishes.models_wish,
                SECOND),
            Row(self.view, taking.take_view, wishes.view_wish),
            Row(self.second, taking.take_second, wishes.second_wish),
            Row(self.cells, tuning_actions.take_cell, wishes.cell_wish),
            Row(self.edits, edit_actions.take_saved, lambda s: s.editing.saving, SECOND),
            Row(self.difference, told("the difference cannot be shown", taking.take_difference),
                difference_request),
            Row(self.measures, told("the frame cannot be measured", taking.take_measured, actions.say),
                wishes.measure_wish, SECOND, forgets=False),
            Row(self.run_measures, taking.take_run_measures, wishes.run_measures_wish, forgets=False),
            Row(self.statistics, taking.take_statistics, wishes.statistics_wish),
            Row(self.thumbnails, told(NO_THUMBNAILS, preset_actions.take_thumbnails, actions.say),
                wishes.thumbnails_wish, forgets=False),
            Row(self.strip, told(NO_STRIP, taking.take_strip, actions.say), wishes.strip_wish, SECOND,
                forgets=False),
            Row(self.left_out, told(NO_TINT, taking.take_left_out, actions.say), wishes.left_out_wish,
                SECOND, forgets=False),
            Row(self.recents, told("recent files cannot be shown", taking.take_recents, actions.say),
                wishes.recents_wish, "apart", forgets=False),
            Row(self.job_images, sweep_actions.take_image, lambda s: s.reports.job, "apart"),
            Row(self.welcome, told("the first page cannot be shown", taking.take_welcome, actions.say),
                lambda s: assets.welcome_path() if s.is_empty else None, SECOND, forgets=False),
            Row(self.guide, told("the guide cannot be shown", guide_actions.take_guide),
                lambda s: assets.guide_path() if s.guide.shown else None, SECOND, forgets=False),
            Row(self.about, told("the versions cannot be listed", about_actions.take_about),
                lambda s: s.scene.drawn_by if s.about.shown else None, SECOND, forgets=False),
            Row(self.clearing, taking.take_nothing, lambda s: s.places, SECOND),
            Row(self.clearing_results, taking.take_nothing, wishes.results_wish, "apart"),
            Row(self.saving, summary_actions.take_saved),
            Row(self.summary_pictures, summary_actions.take_thumbnail, summary_actions.thumbnail_wish,
                "apart"),
            Row(self.sessions, session_actions.take_written, server=SECOND),
            Row(self.autosaves, session_actions.take_written, server=SECOND),
            Row(self.exports, export_actions.take_step, lambda s: s.exports.under_way),
            Row(self.batches, batch_actions.take_progress, lambda s: s.batches.under_way),
            Row(self.listing, browse_actions.take_listing, browse_actions.list_wish, "apart"),
            Row(self.small_files, browse_actions.take_thumbnail, browse_actions.thumbnail_wish, "apart"),
            Row(self.names, export_actions.take_name, export_actions.name_wish, "apart"),
            Row(self.encoders, export_actions.take_encoder, export_actions.encoder_wish, "apart",
                forgets=False),
            Row(self.devices, live_actions.take_devices, live_actions.devices_wish, "apart"),
            Row(self.reveals, export_actions.take_revealed, server="apart"),
            Row(self.changes, changing_runs.take_changed, server=SECOND),
            Row(self.footprints, told("the folder cannot be measured", changing_runs.take_footprint),
                changing_runs.footprint_wish, SECOND),
            Row(self.files, taking.take_written, server=SECOND),
            Row(self.settings, told("settings cannot be saved", actions.take_settings, actions.say),
                server=SECOND),
            Row(self.known, told("the clip's settings cannot be saved", taking.take_nothing, actions.say),
                server=SECOND),
            Row(self.presets, preset_actions.take_kept, server=SECOND),
        )  # fmt: skip

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
        self.ask_once(state)
        self.edits.want(state.editing.saving)
        for channel in (self.files, self.settings, self.known, self.presets, self.edits, self.kept_masks):
            while channel.run_waiting():
                pass


def _still_waiting(request: OpenRequest) -> str:
    return f"still waiting for {request.path}"


def _waits_for_clip(wanted: TakeUpRequest) -> str:
    return f"{wanted.request.run_path.name} waits for its clip {wanted.request.clip_path}"
