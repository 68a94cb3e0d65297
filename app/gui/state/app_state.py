"""Everything that the user can see or has chosen. Plain values: no ImGui, no OpenGL."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from app.enhancement.frame_enhancer import PictureRequest, Pictures
from app.enhancement.methods import EnhancementSettings
from app.enhancement.settable import Scope, Slot
from app.exports.comparison_images import Difference, Other
from app.gui.session_file import Session
from app.gui.state.batches import Batches
from app.gui.state.camera_list import CameraList
from app.gui.state.comparison import Comparison, Side
from app.gui.state.editing import Editing
from app.gui.state.exports import Exports
from app.gui.state.palette import Palette
from app.gui.state.reconstruction import Reconstruction, Waiting
from app.gui.state.second import Second
from app.gui.state.settings_snapshot import SettingsSnapshot
from app.gui.state.tuning import Tuning
from app.gui.state.viewer import Viewer
from app.gui.views.picture_view import PictureView
from app.gui.work.baking import Baked
from app.gui.work.file_writing import WriteRequest
from app.gui.work.measuring import Measured
from app.gui.work.omissions import Omissions, OmissionsRequest
from app.gui.work.opening import OpenRequest
from app.gui.work.presets import KeepPresets
from app.gui.work.reported import Reported
from app.gui.work.run_list import FoundRuns, RunsRequest
from app.gui.work.run_models import ModelRequest
from app.gui.work.settings import Places, Settings
from app.gui.work.strip import LeftOut, Strip
from app.runs.clip_selection import WHOLE, ClipPart
from app.scenes.photos import Photo, PhotoRequest
from app.scenes.scene import Scene
from app.scenes.view_kinds import ViewKind
from app.scenes.view_request import ViewRequest
from app.scenes.viewing import View
from enhance import EnhanceParams
from renderer.clip import Clip
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.train.config import TrainConfig

Closing = Literal["no", "asked", "agreed"]
"""Whether the window shall close although reconstructions are under way."""
LOG_LINES = 500
LOOK_AGAIN = 4.0
"""Seconds after which a shown list of runs is made again."""


@dataclass(frozen=True)
class Banner:
    """What went wrong, in one sentence, until it is dismissed."""

    message: str
    can_stop: bool = False
    """It is of an opening that takes long, which can be given up."""


@dataclass(frozen=True)
class Toast:
    """Good news that goes away by itself."""

    message: str
    until: float
    """On the window's clock, seconds."""


@dataclass
class AppState:
    """The one mutable value of the window; actions change it, drawing reads it."""

    places: Places
    settings: Settings = field(default_factory=Settings)
    clip_options: ClipOptions = DEFAULTS
    """How clips are read, as said at the start."""

    opening: OpenRequest | None = None
    opened_path: Path | None = None
    """The clip, run or file of splats that was opened last."""
    clip: Clip | None = None
    opened_options: ClipOptions = DEFAULTS
    """How `clip` was read."""
    frame_index: int = 0
    frozen_index: int | None = None
    """The frame that the pictures hold while the clip's time goes on."""
    clip_settings: ClipPart = WHOLE
    """Trim and mask of the open clip."""
    known_clips: dict[str, ClipPart] = field(default_factory=dict)
    """Those of all clips, by path."""
    strip: Strip | None = None
    strip_count: int = 0
    """Small pictures that fit into the frame strip, as last laid out."""
    overlay: bool = False
    """Tools and what is masked are tinted in the pictures."""
    left_out: LeftOut | None = None
    mask_tool: str = ""
    """What the next drag over a picture draws: "text", "view" or nothing."""
    mask_start: tuple[float, float] | None = None
    """Where in the picture that drag began."""
    playing: bool = False
    playhead: float = 0.0
    """Position in frames while playing; frame_index is its whole part."""

    params: EnhancementSettings = field(default_factory=EnhanceParams)
    """Of the method that is chosen."""
    scope: Scope = "image"
    tissue_only: bool = False
    """Statistics without tools and black surround."""
    enhancing: bool = True
    """False: plain white light on both sides."""
    peeking: bool = False
    """The original is shown in the enhanced pane while a key is held."""
    past: list[SettingsSnapshot] = field(default_factory=lambda: [SettingsSnapshot()])
    """Settled settings; the last are the present ones. Undo goes back in it."""
    future: list[SettingsSnapshot] = field(default_factory=list)

    pictures: Pictures | None = None
    asked_at: float = 0.0
    """When the newest pictures were asked for, on the window's clock."""
    comparison: Comparison = field(default_factory=Comparison)
    stored: dict[Slot, EnhancementSettings] = field(default_factory=dict)
    """Settings kept as "A" and "B", to compare with."""
    presets: dict[str, EnhancementSettings] = field(default_factory=dict)
    """A person's own, by name."""
    preset_draft: str = ""
    """Name that is being typed for one."""
    measured: Measured | None = None
    others: dict[Side, Other] = field(default_factory=dict)
    """The newest pictures of each side that are neither photo nor present setting."""
    difference: Difference | None = None
    panes_wait: bool = False
    """A picture of `others` is being made."""
    pointer: tuple[int, int] | None = None
    """Column and row of the picture under the pointer."""
    picture_view: PictureView = field(default_factory=PictureView)
    zoom: float = 1.0
    """Screen pixels per picture pixel, as last laid out."""
    wiped: float = 0.5
    """Where the line of the wipe stands in the picture, as a share of its width, as last laid out."""

    reconstruction: Reconstruction = field(default_factory=Reconstruction)
    queue: tuple[Waiting, ...] = ()
    """Reconstructions to be made after the present one, the next one first."""
    wakings: int = 0
    """How often a person has said that some of an earlier session are to be made."""
    closing: Closing = "no"
    model_wish: ModelRequest | None = None
    """The newest model of the present run, or of the last one, until something else is shown."""
    preview: Scene | None = None
    """The model as it was last seen, of the newest run that was cut short."""
    asks_for_runs: bool = False
    """The list of the clip's runs was drawn in the last frame."""
    found_runs: FoundRuns | None = None
    """The newest such list."""
    runs_trouble: str = ""
    asks_for_omissions: bool = False
    """The list of what the next reconstruction leaves out is unfolded."""
    omissions: Omissions | None = None
    """The newest such list."""
    model: Scene | None = None
    view: View | None = None
    editing: Editing = field(default_factory=Editing)
    baked: Baked | None = None
    """Keyframes for the graphics card, of `model` or of one before it; more to come while they are None."""
    view_kind: ViewKind = "color"
    view_size: tuple[int, int] = (0, 0)
    """Pixels of the 3D view, as last laid out; (0, 0) while it is hidden."""
    view_dragged: bool = False
    viewer: Viewer = field(default_factory=Viewer)
    cameras: CameraList = field(default_factory=CameraList)
    second: Second = field(default_factory=Second)
    linked: bool = True
    """The 3D view follows the clip's frame."""
    view_time: float = 0.0
    """In [0, 1]; used when not linked."""

    tuning: Tuning = field(default_factory=Tuning)
    exports: Exports = field(default_factory=Exports)
    batches: Batches = field(default_factory=Batches)

    report: Reported | None = None
    report_place: int = 0
    """Which diagram of it is shown."""
    report_asked: bool = False
    """Its panel is to come to the front."""

    notes: str = ""
    session_path: Path | None = None
    """Where the session was opened from or saved to."""
    recoverable: Path | None = None
    """A session that ended unexpectedly, until it is restored or declined."""
    autosaved: Session | None = None
    """The newest that was saved in passing, or is about to be."""
    autosaved_at: float = 0.0
    autosave_trouble: str = ""

    now: float = 0.0
    """The window's clock, seconds."""
    banner: Banner | None = None
    toast: Toast | None = None
    wishes: tuple[WriteRequest | KeepPresets, ...] = ()
    """What is to be kept on disk, until the next frame hands it to the background work."""
    log: deque[str] = field(default_factory=lambda: deque(maxlen=LOG_LINES))
    help_open: bool = False
    palette: Palette = field(default_factory=Palette)
    processor_draws: bool = True
    """The numba rasteriser draws the 3D view, since there is no graphics card, or OpenGL is slower."""
    drawn_by: str = ""
    """Why, for the tooltip."""

    @property
    def chosen(self) -> SettingsSnapshot:
        """All that is set now."""
        draft, comparison = self.reconstruction, replace(self.comparison, wipe=0.5, flipped=False)
        return SettingsSnapshot(
            self.params,
            self.scope,
            self.tissue_only,
            self.clip_settings,
            comparison,
            draft.config,
            draft.input,
            draft.d_factor,
        )

    @property
    def shown_index(self) -> int:
        """Frame of the two pictures."""
        return self.frame_index if self.frozen_index is None else self.frozen_index

    @property
    def span(self) -> tuple[int, int]:
        """First and last frame that count."""
        return self.clip_settings.span(1 if self.clip is None else len(self.clip))

    @property
    def time(self) -> float:
        """Time of the 3D view in [0, 1]."""
        if self.linked and self.clip is not None:
            first, count = self.timed
            return min(max(self.frame_index - first, 0), count - 1) / count
        return self.view_time

    @property
    def timed(self) -> tuple[int, int]:
        """Of the open clip, the first frame that the 3D view's time is of, and how many."""
        if self.model is not None and self.has_photos:
            return self.model.start, len(self.model.cameras)
        return 0, 1 if self.clip is None else len(self.clip)

    @property
    def part(self) -> ClipPart:
        """What of the open clip the next reconstruction is of."""
        return replace(self.clip_settings, trim=self.span if self.clip_settings.trim else None)

    @property
    def picture_request(self) -> PictureRequest | None:
        """What the two pictures should show now."""
        if self.clip is None:
            return None
        params = self.params if self.enhancing else None
        mask = self.clip_settings.mask
        span = self.span if self.clip_settings.trim else None
        return PictureRequest(self.clip, self.shown_index, params, self.scope, self.tissue_only, mask, span)

    @property
    def pictures_are_stale(self) -> bool:
        return self.pictures is not None and self.pictures.request != self.picture_request

    @property
    def pictures_wait(self) -> bool:
        return self.pictures_are_stale or self.panes_wait

    @property
    def has_view(self) -> bool:
        """There is, or soon will be, something to see in 3D."""
        return self.model is not None or self.reconstruction.is_alive

    @property
    def is_model_alone(self) -> bool:
        """A reconstruction without pictures: splats of a file, or a run whose clip is gone."""
        return self.model is not None and self.clip is None

    @property
    def is_busy(self) -> bool:
        """Something goes on that the window should follow closely."""
        return (
            self.reconstruction.is_alive
            or self.opening is not None
            or self.pictures_wait
            or self.tuning.request is not None
            or self.editing.wish is not None
            or self.exports.is_busy
            or self.batches.under_way is not None
        )

    @property
    def next_waiting(self) -> Waiting | None:
        """The reconstruction that is to be made next: the first that is not asleep."""
        return next((waiting for waiting in self.queue if not waiting.asleep), None)

    @property
    def view_request(self) -> ViewRequest | None:
        """What the 3D view should show now; None without a model or while it is hidden."""
        return self._view_of(self.editing.tinted or self.model)

    @property
    def omissions_request(self) -> OmissionsRequest | None:
        """What the unfolded list should be of."""
        if not self.asks_for_omissions or self.clip is None or self.reconstruction.is_alive:
            return None
        config = replace(self.reconstruction.config, iterations=TrainConfig().iterations)
        return OmissionsRequest(self.clip, config, self.part)

    @property
    def runs_request(self) -> RunsRequest | None:
        """Which runs should be listed now; None while the list is not on screen."""
        if not self.asks_for_runs or self.clip is None:
            return None
        return RunsRequest(self.places.runs, self.clip, int(self.now / LOOK_AGAIN))

    @property
    def plain_view_request(self) -> ViewRequest | None:
        """The same with no selection in colour: for everything but the eye."""
        return self._view_of(self.model)

    def _view_of(self, model: Scene | None) -> ViewRequest | None:
        if model is None or min(self.view_size) < 1:
            return None
        if self.viewer.snapped:
            nearest = ViewRequest.of_frame(model, model.frame_at(self.time))
            return nearest.of_kind(self.view_kind, self.photo)
        whole = ViewRequest.fitted(model, self.time, self.viewer.free, self.view_size)
        return whole.of_kind(self.view_kind)

    @property
    def second_request(self) -> ViewRequest | None:
        """What the second 3D view should show now."""
        first = self.plain_view_request
        return None if first is None else self.beside(first)

    def beside(self, first: ViewRequest) -> ViewRequest | None:
        """The second reconstruction at the moment of `first` through its camera; None without one.

        A photo is of the first one's frames: where the second has others, its difference to them is none.
        """
        shown = self.second.shown
        if shown is None:
            return None
        same = (shown.first, shown.cameras) == (first.scene.first, first.scene.cameras)
        if first.kind == "difference" and not same:
            return replace(first, scene=shown, kind="color", photo=None)
        return replace(first, scene=shown)

    @property
    def has_photos(self) -> bool:
        """The open clip is the one that the 3D view is of."""
        return self.model is not None and self.clip is not None and self.model.is_of(self.clip)

    @property
    def photo(self) -> Photo | None:
        """Of the very frame that a snapped view shows; None while it is being read, or without one."""
        photo = self.viewer.photo
        return photo if photo is not None and photo.request == self.photo_request else None

    @property
    def photo_request(self) -> PhotoRequest | None:
        """The photo that should lie over the 3D view now; None without one."""
        if self.model is None or self.clip is None or not self.viewer.snapped or not self.has_photos:
            return None
        return PhotoRequest(self.clip, self.model.start + self.model.frame_at(self.time))
