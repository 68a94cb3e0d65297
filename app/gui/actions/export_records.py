"""The record of an export as the window stands now, and its sources."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from app.enhancement.frame_enhancer import PictureRequest
from app.enhancement.settable import ENHANCED, ORIGINAL
from app.exports.browser.of_scene import browser_model
from app.exports.exporting import Enhanced, Exported, ExportRequest, MomentFiles
from app.exports.make import Views
from app.exports.meshes.of_scene import surface_mesh
from app.exports.panes import pane_record
from app.exports.records import (
    MEASURES,
    Arrangement,
    FrameRecord,
    MeasuresTable,
    ModelArrays,
    MovingSplats,
    PaneRecord,
    PanesPicture,
    PanesRecord,
    PanesVideo,
    Splats,
    Tracks,
    ViewVideo,
)
from app.exports.sources import Opened
from app.exports.splats.writing import layout_of
from app.files.records import extended
from app.gui.actions import batch_actions, path_actions
from app.gui.actions.export_offers import FORMS, OFFERS, Form, Offer
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.state.panes import frame_share, other_request, shown_mode, source_label
from app.gui.views.comparison import Side, label_of
from app.scenes.clip_speed import FRAMES_PER_SECOND
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.records import MomentRecord
from app.scenes.scene import Scene
from app.scenes.view_request import (
    FrameImage,
    FrameRequest,
    ViewRequest,
    caption_of,
    drawn_record,
    moment_record,
    view_record,
)
from renderer.clip import Clip

Frame = FrameImage | FrameRequest


def format_of(state: AppState, form: Form) -> str:
    """The suffix that is chosen for it."""
    return state.exports.formats.get(form, next(iter(FORMS[form].formats)))


def request_of(state: AppState, what: What, stem: str, suffix: str = "") -> ExportRequest:
    """Into the chosen folder, by a name that begins with `stem`; nothing that it needs is lacking.

    In the format of `suffix`, or the chosen one.
    """
    folder, offer, model = state.export_folder, OFFERS[what], state.scene.model
    suffix = suffix or format_of(state, offer.form)
    if offer.is_of_model:
        assert model is not None
        record = _of_model(state, what, model, suffix)
        return ExportRequest(
            folder, stem, "" if offer.traits.is_folder else suffix, record, Opened(model=model)
        )
    if offer.is_dicom:
        return ExportRequest(folder, stem, suffix, _enhanced(state, offer), Opened())
    clip, moments = state.source.clip, _moments(state, offer)
    views = tuple(view for views in moments for view in views)
    panes = _panes(state, offer)
    record = _record(offer, panes, moments, state.source.span, _rate(offer, clip, model))
    if isinstance(record, PanesPicture) and suffix == ".jpg":
        record = replace(record, quality=state.exports.quality)
    tools = state.picture_request.tools if state.picture_request is not None else None
    own = clip if clip is None or tools is None else tools.of(clip)
    opened = Opened(views, own, model, measured=state.picture.of_clip)
    return ExportRequest(folder, stem, suffix, record, opened)


def _rate(offer: Offer, clip: Clip | None, model: Scene | None) -> float:
    """Frames a second of a video: through time as the clip, of panes the one that is open, goes."""
    if offer.sees == "path":
        return FRAMES_PER_SECOND
    through = model if offer.sees == "time" else clip
    return (through.frames_per_second if through is not None else None) or FRAMES_PER_SECOND


def _enhanced(state: AppState, offer: Offer) -> Enhanced:
    clip, setting = state.source.clip, batch_actions.present_setting(state)
    assert clip is not None
    chosen = replace(setting, clip_options=state.source.options, dicom=state.exports.dicom)
    frame = state.timeline.shown_index if offer.form == "DICOM still" else None
    label = clip.labels[frame] if frame is not None else ""
    return Enhanced(clip.path, chosen, frame, label, len(clip))


def _of_model(state: AppState, what: What, model: Scene, suffix: str) -> Exported:
    """What other programs are to read."""
    unobserved = False if model.tells_shown and not state.exports.unobserved else None

    def splats(frame: int, time: float) -> Splats:
        degree, layout = state.exports.sh_degree, layout_of(suffix)
        return extended(
            Splats, model.record,
            frame=frame, time=time, sh_degree=degree, unobserved=unobserved, layout=layout,
        )  # fmt: skip

    if what == "splats of this moment":
        return splats(model.frame_at(state.time), state.time)
    if what == "splats of all frames":
        frames = range(len(model.cameras))
        return MomentFiles(tuple((f"frame-{at:06d}{suffix}", splats(at, model.time(at))) for at in frames))
    if what == "arrays of all frames":
        return extended(ModelArrays, model.record, renderer=ON_CPU, moments=_frames(model))
    speed = model.frames_per_second or FRAMES_PER_SECOND
    if what == "page for browsers":
        beyond = state.settings.unobserved
        return browser_model(model, model.cameras[0], speed, unobserved=beyond)
    if what == "splats through time":
        seconds = len(model.cameras) / speed
        return extended(MovingSplats, model.record, seconds=seconds, unobserved=unobserved)
    if what == "surface through time":
        return surface_mesh(model, speed)
    if what == "surface of all frames":
        times = enumerate(map(model.time, range(len(model.cameras))))
        return MomentFiles(
            tuple((f"frame-{at:06d}{suffix}", surface_mesh(model, speed, at, time)) for at, time in times)
        )
    if what == "tracks of the measured points":
        measured = state.scene.viewer.measurement
        start = MomentRecord(time=measured.time, camera=model.camera_at(measured.time), near=model.near)
        return extended(Tracks, model.record, places=measured.points, start=start, moments=_frames(model))
    if what == "cameras of the clip":
        return path_actions.clip_cameras(model)
    return path_actions.path_cameras(model, state.scene.cameras.views.path)


def _frames(model: Scene) -> tuple[MomentRecord, ...]:
    """Every frame, as the clip's camera sees it."""
    views = (ViewRequest.of_frame(model, frame) for frame in range(len(model.cameras)))
    return tuple(
        replace(moment_record(view), frame=frame, near=model.near) for frame, view in enumerate(views)
    )


def _record(
    offer: Offer, panes: PanesRecord, moments: tuple[Views, ...], span: tuple[int, int], rate: float
) -> PanesPicture | PanesVideo | MeasuresTable | ViewVideo:
    form = offer.form
    if form == "picture":
        seen = tuple(view_record(view, ON_CPU) for views in moments for view in views)
        return extended(PanesPicture, panes, views=seen)
    if form == "view video":
        return ViewVideo(
            views=tuple(drawn_record(view, ON_CPU) for view in moments[0]),
            moments=tuple(moment_record(views[0]) for views in moments),
            frames_per_second=rate,
        )
    first, last = span
    if form == "measures":
        return extended(
            MeasuresTable,
            panes,
            first_frame=first,
            last_frame=last,
            measures=MEASURES,
            measured_over="field of view",
            noise_cut="unclipped",
            lengths="by size",
        )
    return extended(PanesVideo, panes, first_frame=first, last_frame=last, frames_per_second=rate)


def _panes(state: AppState, offer: Offer) -> PanesRecord:
    """What the sides show, one of them where both show the same, but for their difference, and how they are
    laid out."""
    picture, sides = state.picture_request, offer.sides
    if picture is None or not sides:
        return PanesRecord()
    mode = shown_mode(state) if offer.as_shown else "side by side"
    if mode == "flip":
        sides, mode = ("left" if state.comparing.chosen.flipped else "right",), "side by side"
    panes = tuple(_pane(state, side, picture) for side in sides)
    if offer.form == "picture":
        panes = tuple(_as_on_screen(state, *pair) for pair in zip(sides, panes, strict=True))
    return PanesRecord(
        clip_options=state.source.options,
        frame=FrameRecord(index=picture.frame_index, label=picture.clip.labels[picture.frame_index]),
        **vars(state.exports.sizing),
        arrangement=Arrangement(mode, state.comparing.wiped),
        panes=panes if mode == "difference" else tuple(dict.fromkeys(panes)),
    )


def _pane(state: AppState, side: Side, picture: PictureRequest) -> PaneRecord:
    """What a side shows; in white light and while the original is peeked at the frame, whatever is chosen."""
    source, original = state.comparing.chosen.source(side), replace(picture, params=None)
    active = state.enhancement.active and not state.enhancement.peeking
    if active and source == ENHANCED and picture.params is not None:
        return pane_record("Enhanced", original, picture.params)
    request = other_request(state, side) if active else None
    # As on screen, the original also where there is nothing else to show.
    if request is None:
        return pane_record(source_label(state, ORIGINAL), original)
    frames = request.by.record.trained_on if isinstance(request.by, Scene) else ""
    title = f"{label_of(source)}   from {frames}" if frames else label_of(source)
    return pane_record(title, request.original, request.by, request.background)


def _as_on_screen(state: AppState, side: Side, pane: PaneRecord) -> PaneRecord:
    """With the statistics of the picture on screen where no file could measure them again: smoothed over a
    live source, without tools that were masked in the window, or of one frame as long as the clip's are not
    known."""
    asked, wanted = state.picture_request, other_request(state, side)
    if pane.params is None or asked is None:
        return pane
    if not (state.live.flows or asked.tools is not None or asked.of_clip == "later"):
        return pane
    shown = state.picture.pictures
    if wanted is not None:
        made = (other.made for other in state.comparing.others.values() if other.request == wanted)
        asked, shown = wanted.original, next(made, None)
    if shown is None or shown.request.params is None:
        return pane
    of_shown = shown.request.statistics_request(shown.request.params)
    same = of_shown == asked.statistics_request(pane.params)
    if asked.scope == "image" or asked.of_clip == "own":
        same = same and shown.request.frame_index == asked.frame_index
    return replace(pane, given=shown.statistics) if same else pane


def _moments(state: AppState, offer: Offer) -> tuple[Views, ...]:
    """The 3D view once, or once a frame of its video; each time with the second one, where there is one."""
    view = state.plain_view_request
    if view is None or offer.sees == "no":
        return ()
    if offer.sees == "still":
        return (_with_second(state, view, state.frame_image or state.frame_request),)
    if offer.sees == "path":
        return tuple(_with_second(state, first, None) for first in _along_path(state, view.scene))
    return tuple(_with_second(state, *moment) for moment in _through_time(state, view.scene))


def _with_second(state: AppState, first: ViewRequest, frame: Frame | None) -> Views:
    """Each with as much of the frame over it as on screen."""
    views, second = [_under_frame(state, first, frame)], state.scene.beside(first)
    if second is not None:
        views.append(_second_under_frame(state, first, second, frame))
    return tuple(_as_chosen(state, one) for one in views)


def _second_under_frame(
    state: AppState, first: ViewRequest, second: ViewRequest, frame: Frame | None
) -> ViewRequest:
    """Of a run with other frames it is said to be without: its file would look for the frame among those."""
    under = _under_frame(state, second, frame)
    if under == second or state.scene.has_frames_of(first):
        return under
    return replace(second, caption=f"{caption_of(second)}   without the frame over it")


def _under_frame(state: AppState, view: ViewRequest, frame: Frame | None) -> ViewRequest:
    """Of two views of which the first is the difference to the frame, neither has it over it."""
    share = frame_share(state, view.scene)
    if frame is None or state.scene.kind == "difference" or not share:
        return view
    return replace(view, reference=frame, frame_share=share)


def _as_chosen(state: AppState, view: ViewRequest) -> ViewRequest:
    """In the size and with the averaging that are chosen."""
    view, clip = state.over_background(view), state.source.clip
    if clip is not None and view.scene.is_of_other(clip):
        view = replace(view, caption=f"OF ANOTHER CLIP: {view.scene.title}\n{caption_of(view)}")
    return replace(sized(view, state.exports.view_size), supersampling=state.exports.supersampling)


def _through_time(state: AppState, scene: Scene) -> Iterator[tuple[ViewRequest, FrameRequest | None]]:
    """Every frame of the clip, from here or through its own cameras, where its frame lies over it, or a
    difference is to that."""
    clip = state.source.clip if state.has_frames else None
    for frame in range(len(scene.cameras)):
        if state.scene.viewer.snapped:
            reference = FrameRequest(clip, scene.start + frame) if clip is not None else None
            yield ViewRequest.of_frame(scene, frame).of_kind(state.scene.kind, reference), reference
        else:
            view = ViewRequest.fitted(scene, scene.time(frame), state.scene.viewer.free, state.scene.size)
            yield view.of_kind(state.scene.kind), None


def _along_path(state: AppState, scene: Scene) -> Iterator[ViewRequest]:
    """As `vesselsplat export --path` goes along it."""
    for key in state.scene.cameras.views.path.moments(FRAMES_PER_SECOND):
        yield ViewRequest(scene, key.time, key.camera.fitted(*state.scene.size)).of_kind(state.scene.kind)


def sized(view: ViewRequest, size: tuple[int, int] | None) -> ViewRequest:
    """With so many pixels; without a size in its own shape, no smaller than the clip's frames.

    A difference keeps the frame's shape, within the size, and so does what a frame lies over.
    """
    camera, clip_camera = view.camera, view.scene.cameras[0]
    if size is None:
        scale = max(1.0, clip_camera.width / camera.width, clip_camera.height / camera.height)
    elif view.kind == "difference" or view.frame_share:
        scale = min(size[0] / camera.width, size[1] / camera.height)
    else:
        return replace(view, camera=camera.fitted(*size))
    width, height = max(1, round(scale * camera.width)), max(1, round(scale * camera.height))
    return replace(view, camera=camera.resized(width, height))
