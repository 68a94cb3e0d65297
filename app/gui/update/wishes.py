"""The requests that the state makes now, one function for each kind of background work."""

from __future__ import annotations

from pathlib import Path

from app.enhancement.clip_statistics import StatisticsRequest
from app.enhancement.frame_enhancer import Pictures
from app.enhancement.methods import PAPER, VESSEL, preset_of
from app.exports.comparison_images import OtherRequest
from app.gui.actions import batch_actions, queue_actions
from app.gui.state.app_state import AppState
from app.gui.state.panes import other_request
from app.gui.state.scene import Viewed
from app.gui.views.comparison import Side
from app.gui.work.baking import BakeRequest, can_bake
from app.gui.work.beside import BesideRequest
from app.gui.work.clip_scale import SCALED, ScaleRequest
from app.gui.work.depths import WaysRequest
from app.gui.work.kept_layout import NAME, SealRequest
from app.gui.work.masking import LeftOutRequest
from app.gui.work.neighbours import NeighboursRequest
from app.gui.work.presets import presets_with
from app.gui.work.queued_clips import QueuedClipRequest
from app.gui.work.recents import RecentsRequest
from app.gui.work.run_measures import RunMeasuresRequest
from app.gui.work.strip import StripRequest
from app.gui.work.thumbnails import ThumbnailsRequest
from app.gui.work.tuning import CellRequest
from app.gui.work.writing import QueueRequest
from app.kernels.progress import Kind
from app.scenes.drawer import View
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest

REST = 0.25
"""Seconds without a new picture before what can wait is done: measuring, small pictures."""
SLOW_VIEW = 60.0
"""Milliseconds above which the 3D view is drawn smaller while it moves."""
REDUCED = 0.5


def at_rest(state: AppState) -> bool:
    """Whether no new picture has been asked for lately: no slider waits for what is wished for then."""
    moves = state.timeline.playing or state.live.flows
    return not moves and state.window.now - state.picture.asked_at >= REST


def measure_wish(state: AppState) -> Pictures | None:
    """The pictures on screen, once both are there."""
    pictures = state.picture.pictures
    if pictures is None or pictures.enhanced is None or not at_rest(state) or state.pictures_are_stale:
        return None
    return pictures if pictures.request.of_clip != "later" else None


def statistics_wish(state: AppState) -> StatisticsRequest | None:
    """Those of the clip, while they are not known: at rest, as each frame of a video is looked for."""
    request = state.asked_pictures
    if request is None or request.params is None or request.of_clip != "later" or not at_rest(state):
        return None
    return None if state.pictures_are_stale else request.statistics_request(request.params)


def thumbnails_wish(state: AppState) -> ThumbnailsRequest | None:
    """What each preset makes of the frame on screen, while the menu of presets is open."""
    pictures = state.picture.pictures
    if pictures is None or not state.enhancement.choosing or state.pictures_are_stale:
        return None
    if state.lacks(PAPER) or state.lacks(VESSEL):
        return None
    return ThumbnailsRequest(pictures, tuple(presets_with(state.enhancement.presets).items()))


def strip_wish(state: AppState) -> StripRequest | None:
    """The small images of the clip, once its pictures are there."""
    clip, count = state.source.clip, state.timeline.strip_count
    if clip is None or state.picture.pictures is None or not at_rest(state) or count < 1:
        return None
    return StripRequest(clip, count)


def left_out_wish(state: AppState) -> LeftOutRequest | None:
    """At once: a person has asked for the tint."""
    clip = state.source.clip
    if clip is None or state.picture.pictures is None or not state.picture.overlay:
        return None
    return LeftOutRequest(clip, state.timeline.shown_index, state.source.part.mask, state.drawn_tools)


def ways_wish(state: AppState) -> WaysRequest | None:
    """Where the depth of the clip can come from, once its pictures are there."""
    bare, known = state.source.bare, state.source.depth_ways
    if bare is None or known is not None or state.picture.pictures is None:
        return None
    return WaysRequest(bare, state.source.options)


def neighbours_wish(state: AppState) -> NeighboursRequest | None:
    """Of a single image, once it is there."""
    clip, path = state.source.clip, state.source.path
    if clip is None or path is None or clip.format != "image" or state.picture.pictures is None:
        return None
    return NeighboursRequest(path)


def side_wish(state: AppState, side: Side) -> OtherRequest | None:
    """What a pane waits for: neither frame nor present setting, and made for no side yet."""
    wanted = other_request(state, side)
    if wanted is None or state.lacks(_kind_of(wanted)):
        return None
    return wanted if all(made.request != wanted for made in state.comparing.others.values()) else None


def _kind_of(wanted: OtherRequest) -> Kind | None:
    """What it needs of the one-time preparation; a baseline needs nothing."""
    if isinstance(wanted.by, Scene):
        return "3D view"
    return None if isinstance(wanted.by, str) else preset_of(wanted.by)


def cell_wish(state: AppState) -> CellRequest | None:
    """The next cell of the tuning grid."""
    return None if state.lacks(preset_of(state.enhancement.params)) else state.tuning.request


def view_wish(state: AppState) -> ViewRequest | None:
    """What the processor is to draw of the 3D view, smaller while it moves when a whole one takes long; None
    where the card draws."""
    request = state.view_request if state.scene.is_drawn_by_processor and not state.lacks("3D view") else None
    moves = state.scene.dragged or state.moves
    if request is None or not moves or not _is_slow(state.scene.view, state.scene.second.view):
        return request
    return request.scaled(REDUCED)


def second_wish(state: AppState) -> ViewRequest | None:
    """Of the first one's moment, camera and size."""
    first = view_wish(state)
    return None if first is None else state.scene.beside(first)


def _is_slow(*views: View | None) -> bool:
    """Whether the last pictures together would have taken long at full size."""
    shares = [(view.milliseconds, view.request.reduced) for view in views if view is not None]
    return sum(spent / REDUCED**2 if reduced else spent for spent, reduced in shares) > SLOW_VIEW


def scale_wish(state: AppState) -> ScaleRequest | None:
    """The scale of a view in the colours of values, of a model that stays as it is."""
    shown, kind = state.scene.model, state.scene.kind
    if shown is None or shown.live or kind not in SCALED or state.lacks("3D view"):
        return None
    wanted, known = ScaleRequest(shown, kind), state.scene.clip_scale
    return wanted if known is None or known.request != wanted else None


def bake_wish(state: AppState, viewed: Viewed) -> BakeRequest | None:
    """The next part of the keyframes of what a 3D view shows, where the card draws: part by part, so that
    pictures are made between them."""
    shown, baked = viewed.model, viewed.baked
    if state.scene.processor_draws or shown is None or not can_bake(shown) or state.lacks("3D view"):
        return None
    if baked is None or baked.request.shown is not shown:
        return BakeRequest(shown)
    return BakeRequest(shown, baked.baker, baked.request.part + 1) if baked.keyframes is None else None


def shown_wish(state: AppState, viewed: Viewed) -> Scene | None:
    """Of what a 3D view shows, which Gaussians the frames show: before it is seen from elsewhere."""
    model = viewed.model
    if model is None or not model.tells_shown or state.lacks("3D view") or not at_rest(state):
        return None
    return model if model.shown_so_far is None else None


def run_measures_wish(state: AppState) -> RunMeasuresRequest | None:
    """Of the run that is shown, while its measures are on screen and not known."""
    wanted, known = state.run_measures_request, state.runs.measures
    if not state.runs.sees_measures or wanted is None or not at_rest(state) or state.lacks("3D view"):
        return None
    return None if known is not None and known.request == wanted else wanted


def recents_wish(state: AppState) -> RecentsRequest | None:
    """Images of what was opened lately, while the first page shows them. Where nothing is remembered, earlier
    ones are forgotten at once."""
    if state.settings.recent and not state.is_empty:
        return None
    return RecentsRequest(state.settings.recent, state.places.thumbnails)


def models_wish(state: AppState) -> BesideRequest | None:
    """Which of what was opened lately can be seen beside the model that is shown."""
    if state.scene.model is None:
        return None
    return BesideRequest(state.settings.recent, state.runs.reconstruction.status)


def queue_wish(state: AppState) -> QueueRequest:
    """The queue, as the next session is to find it."""
    return QueueRequest(state.places.config, queue_actions.to_keep(state))


def layout_wish(state: AppState) -> SealRequest | None:
    """The layout, whenever the runner has written it."""
    changes = state.window.layout_changes
    return SealRequest(state.places.config / NAME, changes) if changes else None


def clip_wish(state: AppState) -> QueuedClipRequest | None:
    """The clip of the reconstruction that is to be made next, where it is of an earlier session."""
    first = state.runs.next_waiting
    if first is None or first.clip is not None:
        return None
    return QueuedClipRequest(first.request, state.runs.wakings)


def results_wish(state: AppState) -> frozenset[Path]:
    """Where what killed windows have left of batches is cleared away: where the next one writes, and others
    have."""
    return frozenset({batch_actions.results_folder(state), state.places.pictures})
