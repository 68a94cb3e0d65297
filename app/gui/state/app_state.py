"""Everything that the user can see or has chosen. Plain values: no ImGui, no OpenGL."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from app.enhancement.clip_statistics import OfClip
from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.methods import preset_of
from app.enhancement.parameter_grid import Setting
from app.files.legible import in_one_line
from app.gui.state.choosing import Purpose
from app.gui.state.editing import Editing
from app.gui.state.enhancement import Enhancement, SettingsSnapshot
from app.gui.state.exports import Batches, Exports
from app.gui.state.live import Live
from app.gui.state.masking import Masking
from app.gui.state.picture import Comparing, Picture
from app.gui.state.presenting import Presenting, SecondWindow
from app.gui.state.reconstruction import Runs
from app.gui.state.scene import ShownScene
from app.gui.state.session import KeptSession
from app.gui.state.shipped import ShownAbout, ShownGuide, Welcome
from app.gui.state.source import Reports, Source, Timeline
from app.gui.state.summary import CaseSummary
from app.gui.state.tuning import Tuning
from app.gui.state.window import WindowFrame
from app.gui.work.masking import DrawnTools, folder_of
from app.gui.work.measuring import Measured
from app.gui.work.omissions import OmissionsRequest
from app.gui.work.opening import VIEW_SUFFIXES
from app.gui.work.run_measures import RunMeasuresRequest
from app.gui.work.runs import RunsRequest
from app.gui.work.settings import Places, Settings
from app.kernels.progress import Kind
from app.runs.clip_selection import WHOLE
from app.scenes.backgrounds import BACKGROUNDS, Background
from app.scenes.scene import Scene
from app.scenes.view_request import FrameImage, FrameRequest, ViewRequest
from renderer.clip import Clip
from renderer.train.config import TrainConfig

LOOK_AGAIN = 4.0
"""Seconds after which a shown list of runs is made again."""


@dataclass(slots=True)
class AppState:
    """The one mutable value of the window, a part a concern; actions change it, drawing reads it.

    What follows from several parts together is a property here.
    """

    places: Places
    settings: Settings = field(default_factory=Settings)
    saved_settings: Settings = field(init=False)
    """As this window last asked for them to be written, or as it read them."""
    source: Source = field(default_factory=Source)
    timeline: Timeline = field(default_factory=Timeline)
    live: Live = field(default_factory=Live)
    enhancement: Enhancement = field(default_factory=Enhancement)
    picture: Picture = field(default_factory=Picture)
    masking: Masking = field(default_factory=Masking)
    comparing: Comparing = field(default_factory=Comparing)
    scene: ShownScene = field(default_factory=ShownScene)
    runs: Runs = field(default_factory=Runs)
    editing: Editing = field(default_factory=Editing)
    tuning: Tuning = field(default_factory=Tuning)
    exports: Exports = field(default_factory=Exports)
    batches: Batches = field(default_factory=Batches)
    summary: CaseSummary = field(default_factory=CaseSummary)
    session: KeptSession = field(default_factory=KeptSession)
    reports: Reports = field(default_factory=Reports)
    welcome: Welcome = field(default_factory=Welcome)
    guide: ShownGuide = field(default_factory=ShownGuide)
    about: ShownAbout = field(default_factory=ShownAbout)
    window: WindowFrame = field(default_factory=WindowFrame)
    presenting: Presenting = field(default_factory=Presenting)
    second_window: SecondWindow = field(default_factory=SecondWindow)

    def __post_init__(self) -> None:
        self.saved_settings = self.settings

    @property
    def chosen(self) -> SettingsSnapshot:
        """All that is set now."""
        draft, comparison = self.runs.reconstruction, replace(self.comparing.chosen, wipe=0.5, flipped=False)
        return SettingsSnapshot(
            self.enhancement.params,
            self.enhancement.scope,
            self.enhancement.pixels,
            self.source.part,
            comparison,
            draft.config,
            draft.input,
            draft.kept,
            self.source.reading.depth,
            self.source.reading.baseline,
            self.source.reading.field_of_view,
            self.scene.cameras.views,
            self.summary.items,
        )

    @property
    def time(self) -> float:
        """Time of the 3D view in [0, 1]."""
        if self.follows_clip:
            first, count = self.timed
            return min(max(self.timeline.frame_index - first, 0), count - 1) / count
        return self.scene.own_time

    @property
    def follows_clip(self) -> bool:
        """The 3D view is at the time of the open clip: it is to be, and is not of another one."""
        return self.scene.linked and self.source.clip is not None and not self.shows_other_clip

    @property
    def shows_other_clip(self) -> bool:
        """The 3D view is of another clip than the open one."""
        model, clip = self.scene.model, self.source.clip
        return model is not None and clip is not None and model.is_of_other(clip)

    @property
    def timed(self) -> tuple[int, int]:
        """Of the open clip, the first frame that the 3D view's time is of, and how many."""
        if self.scene.model is not None and self.has_frames:
            return self.scene.model.start, len(self.scene.model.cameras)
        return 0, 1 if self.source.clip is None else len(self.source.clip)

    @property
    def moments(self) -> int:
        """Frames of the open clip, or of a reconstruction without one; 0 for nothing."""
        if self.source.clip is not None:
            return len(self.source.clip)
        return 0 if self.scene.model is None else len(self.scene.model.cameras)

    @property
    def moment(self) -> int:
        """Which of them the timeline stands on."""
        model = self.scene.model
        if model is None or self.source.clip is not None:
            return self.timeline.frame_index
        return model.frame_at(self.scene.own_time)

    def is_set(self, setting: Setting) -> bool:
        """The window enhances by this setting of the tuning grid, as it was tried."""
        grid, chosen = self.tuning.grid, self.enhancement
        if grid is None:
            return False
        tried = (setting.params, grid.picture.scope, grid.picture.pixels)
        return tried == (chosen.params, chosen.scope, chosen.pixels)

    @property
    def picture_request(self) -> PictureRequest | None:
        """What the two pictures should show now; of a live source, whatever came last."""
        if self.source.clip is None:
            return None
        if self.live.flows and self.picture.pictures is not None:
            return self.picture.pictures.request
        params = self.enhancement.params if self.enhancement.active else None
        mask = self.source.part.mask
        span = self.source.span if self.source.part.trim else None
        request = PictureRequest(
            self.source.clip,
            self.timeline.shown_index,
            params,
            self.enhancement.scope,
            self.enhancement.pixels,
            mask,
            span,
            tools=self.drawn_tools if self.enhancement.pixels == "tissue" else None,
        )
        return replace(request, of_clip=self._of_clip(request))

    @property
    def drawn_tools(self) -> DrawnTools | None:
        """Those that are masked in the window."""
        masks = self.source.training_part.tool_masks
        return None if masks is None else DrawnTools(masks, self.masking.changes)

    @property
    def asked_pictures(self) -> PictureRequest | None:
        """What can be shown of that now: the original alone until the method's kernels are compiled."""
        request = self.picture_request
        if request is None or request.params is None or not self.lacks(preset_of(request.params)):
            return request
        return replace(request, params=None, of_clip=None)

    def lacks(self, kind: Kind | None) -> bool:
        """It waits for the one-time preparation."""
        now = self.window.preparation
        return now is not None and kind is not None and not now.has(kind)

    def _of_clip(self, request: PictureRequest) -> OfClip:
        if request.params is None or request.scope == "image":
            return None
        known, wanted = self.picture.of_clip, request.statistics_request(request.params)
        return (known.told(wanted) if known is not None else None) or "later"

    @property
    def pictures_are_stale(self) -> bool:
        return self.picture.pictures is not None and self.picture.pictures.request != self.asked_pictures

    @property
    def is_unreadable(self) -> bool:
        """The frame that is asked for has been tried in vain."""
        return self.picture.failed is not None and self.picture.failed == self.asked_pictures

    @property
    def opens(self) -> str:
        """What takes the place of all that is shown once it is there, in words; empty when nothing does."""
        request = self.source.opening
        if request is None and self.live.connects:
            return "Connecting to the live source…"
        if request is None or request.path.suffix.lower() in VIEW_SUFFIXES:
            return ""
        return f"Opening {in_one_line(request.path.name)}…"

    @property
    def is_frozen(self) -> bool:
        """The pictures hold a frame of a clip that plays, or of a live source."""
        return self.timeline.frozen_index is not None or self.live.still is not None

    @property
    def measured(self) -> Measured | None:
        """Measures of the clip that is shown, and of none that is on its way out."""
        found, shown = self.picture.measured, self.picture.pictures
        if found is None or shown is None or self.opens:
            return None
        return found if found.pictures.request.clip is shown.request.clip else None

    @property
    def pictures_wait(self) -> bool:
        return self.pictures_are_stale or self.comparing.waits

    @property
    def has_view(self) -> bool:
        """There is, or soon will be, something to see in 3D."""
        return self.scene.model is not None or self.runs.reconstruction.is_alive

    @property
    def is_model_alone(self) -> bool:
        """A reconstruction without pictures: splats of a file, or a run whose clip is gone."""
        return self.scene.model is not None and self.source.clip is None

    @property
    def is_empty(self) -> bool:
        """Nothing is open: the first page is shown."""
        return self.source.clip is None and self.scene.model is None

    @property
    def moves(self) -> bool:
        """What is shown changes by itself, frame by frame."""
        return self.timeline.playing or self.scene.viewer.moving or self.scene.cameras.playing

    @property
    def is_busy(self) -> bool:
        """Something goes on that the window should follow closely."""
        return (
            self.runs.reconstruction.is_alive
            or self.source.opening is not None
            or self.live.session is not None
            or self.pictures_wait
            or self.tuning.request is not None
            or self.editing.wish is not None
            or self.masking.is_busy
            or self.exports.is_busy
            or self.batches.under_way is not None
        )

    @property
    def export_folder(self) -> Path:
        """Where images, videos and other exports go."""
        return self.folder_of("export") or self.places.pictures

    def folder_of(self, purpose: Purpose) -> Path | None:
        """Where a person was last for this purpose of a dialog."""
        known = self.settings.folders.get(purpose)
        return self.window.folders.get(purpose) or (Path(known) if known else None)

    @property
    def view_request(self) -> ViewRequest | None:
        """What the 3D view should show now; None without a model or while it is hidden. A selection in colour
        would differ from the frame, which is no error of the model."""
        view = self._view_of(self.editing.tinted or self.scene.model)
        if view is None or view.kind == "difference":
            return self.plain_view_request
        return view.so_far

    @property
    def masks_clip(self) -> Clip | None:
        """The open clip as its tools are masked: without depth that is worked out."""
        return None if self.source.is_live_frame else self.source.bare or self.source.clip

    @property
    def masks_folder(self) -> Path:
        """Where the tool masks of the open clip lie, or will."""
        assert self.masks_clip is not None
        return folder_of(self.places.tool_masks, self.masks_clip, self.source.options)

    @property
    def omissions_request(self) -> OmissionsRequest | None:
        """What the unfolded list should be of."""
        clip, busy = self.source.clip, self.runs.reconstruction.is_alive
        if not self.runs.asks_for_omissions or clip is None or self.source.is_live_frame or busy:
            return None
        config = replace(self.runs.reconstruction.config, iterations=TrainConfig().iterations)
        return OmissionsRequest(clip, config, self.source.training_part)

    @property
    def runs_request(self) -> RunsRequest | None:
        """Which runs should be listed now; None while the list is not on screen, and has the run that is
        shown: menus offer to rename and delete that one."""
        found, shown = self.runs.found, self.runs.reconstruction.run_path
        is_ours = shown is not None and shown.parent == self.places.runs
        lacks = is_ours and (found is None or all(run.path != shown for run in found.runs))
        if not (lacks or self.runs.is_listed) or self.source.clip is None or self.source.is_live_frame:
            return None
        return RunsRequest(self.places.runs, self.source.clip, int(self.window.now / LOOK_AGAIN))

    @property
    def run_measures_request(self) -> RunMeasuresRequest | None:
        """What the finished run that is shown is measured by; None where its clip is not open as it was."""
        run, clip = self.runs.reconstruction, self.source.clip
        shown = self.editing.base or self.scene.model
        if run.status != "finished" or run.request is None or shown is None or clip is None:
            return None
        is_shown = shown.path == run.run_path and not shown.live and self.has_frames
        if not is_shown or not run.request.clip_options.reads_as(self.source.options):
            return None
        known = shown.record.clip  # It knows the surround that training found.
        part = run.request.part if known is None else (known.part or WHOLE).kept_in(run.request.run_path)
        lens = None if known is None else known.calibration
        found = None if lens == self.source.options.calibration else lens
        return RunMeasuresRequest(shown, clip, part, run.request.config, found)

    @property
    def plain_view_request(self) -> ViewRequest | None:
        """The same with no selection in colour: for everything but the eye."""
        return self._view_of(self.scene.model)

    def _view_of(self, model: Scene | None) -> ViewRequest | None:
        if model is None or min(self.scene.size) < 1:
            return None
        if self.scene.viewer.snapped:
            view = ViewRequest.of_frame(model, model.frame_at(self.time))
        else:
            view = ViewRequest.fitted(model, self.time, self.scene.viewer.free, self.scene.size)
        view = self.over_background(view.of_kind(self.scene.kind, self.frame_image))
        return replace(view, scale=self.scene.steady_scale)

    def over_background(self, view: ViewRequest) -> ViewRequest:
        """With what is chosen for where nothing was observed; what is edited is seen whole."""
        unobserved = self.settings.unobserved or self.editing.active
        return replace(view, background=self.background, unobserved=unobserved)

    @property
    def background(self) -> Background:
        """Of reconstructions, where nothing was observed."""
        return BACKGROUNDS[self.settings.background]

    @property
    def second_request(self) -> ViewRequest | None:
        """What the second 3D view should show now."""
        first = self.plain_view_request
        return None if first is None else self.scene.beside(first)

    @property
    def has_frames(self) -> bool:
        """The open clip is the one that the 3D view is of."""
        return (
            self.scene.model is not None
            and self.source.clip is not None
            and self.scene.model.is_of(self.source.clip)
        )

    @property
    def frame_image(self) -> FrameImage | None:
        """Of the very frame that a snapped view shows; None while it is being read, or without one."""
        newest = self.scene.viewer.frame_image
        return newest if newest is not None and newest.request == self.frame_request else None

    @property
    def frame_request(self) -> FrameRequest | None:
        """The frame that should lie over the 3D view now; None without one."""
        if (
            self.scene.model is None
            or self.source.clip is None
            or not self.scene.viewer.snapped
            or not self.has_frames
        ):
            return None
        return FrameRequest(self.source.clip, self.scene.model.start + self.scene.model.frame_at(self.time))
