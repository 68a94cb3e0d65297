"""Writes every kind of exported file from its record and sources: for commands, window and replay alike."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from app.enhancement.contact_sheet import contact_sheet, tile
from app.enhancement.dicom_files import is_dicom_name, write_dicom_film, write_enhanced_still
from app.enhancement.enhance_files import enhanced, write_enhanced_video
from app.enhancement.methods import METHODS, MethodEnhancer
from app.enhancement.parameter_grid import Setting, tried
from app.enhancement.records import EnhancedPicture, EnhancedVideo, Made, TuningSheet
from app.enhancement.settable import drawn
from app.errors import UserError
from app.exports.browser.of_scene import far_off, page_windows
from app.exports.browser.page import browser_page
from app.exports.measures import Row, measures_at, rows_at, write_measures
from app.exports.meshes.writing import write_surface
from app.exports.panes import PaneMaker, arranged
from app.exports.records import (
    BrowserModel,
    CaseSummary,
    Depth,
    Export,
    MeasuresTable,
    ModelArrays,
    MovingSplats,
    PanesPicture,
    PanesVideo,
    Render,
    RenderVideo,
    SpanRecord,
    Splats,
    SurfaceMesh,
    Tracks,
    ViewVideo,
)
from app.exports.research.model_arrays import write_model_arrays
from app.exports.research.tracks import write_tracks
from app.exports.sheet import Panel, sheet
from app.exports.sizing import Sizing
from app.exports.sources import Sources
from app.exports.splats.writing import write_moment, write_moving
from app.exports.summary.writing import write_summary
from app.files.atomic import together, write_bytes
from app.files.color_profiles import profile_of
from app.files.dicom.choices import DEIDENTIFIED
from app.files.image_files import write_image
from app.files.image_series import Series, timing_of
from app.files.provenance import write_png, write_sidecar
from app.files.records import Source
from app.files.stepping import map_steps
from app.files.timing import Timing
from app.files.video import write_frames
from app.scenes import view_request
from app.scenes.color_bar import with_bar
from app.scenes.cpu_rendering import colored_depth
from app.scenes.depth_steps import in_steps
from app.scenes.drawer import Drawer
from app.scenes.observed import observed
from app.scenes.records import DrawnRecord, MomentRecord, ViewRecord
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest
from enhance.surround import inside
from renderer.clip import ByteImage
from renderer.closing import closing_radius
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.unobserved import BLACK

Steps = Generator[int, None, None]
Views = tuple[ViewRequest, ...]
"""Of one moment: the 3D view, and the second one where there is one."""


def make(record: Export, sources: Sources, target: Path) -> Steps:
    """Write the file that `record` is of, with the record and what was found out while it was made.

    Yields how many of its pictures are made; closed before its end, it leaves nothing behind.

    Raises:
        OSError, UserError, ClipError, ImageError: what cannot be read, made or written.
    """
    match record:
        case EnhancedPicture():
            series = _series(record, sources)
            image, made = _enhanced(record, series, MethodEnhancer())
            if is_dicom_name(target):
                write_enhanced_still(target, image, made, series.sources)
            else:
                profile = profile_of(series.sources[record.frame or 0], image)
                write_image(target, image, made.signed, profile=profile)
        case EnhancedVideo():
            yield from _enhanced_video(record, sources, target)
        case TuningSheet():
            _tuning_sheet(record, sources, target)
        case Render():
            _render(record, sources, target)
        case Depth():
            _depth(record, sources, target)
        case RenderVideo():
            yield from _render_video(record, sources, target)
        case Splats():
            write_moment(record, _observed(record, sources.scene(record)), target)
        case MovingSplats():
            yield from write_moving(record, _observed(record, sources.scene(record)), target)
        case ModelArrays():
            yield from write_model_arrays(
                record, sources.scene(record), sources.drawer(record.renderer), target
            )
        case Tracks():
            yield from write_tracks(record, sources.scene(record), target)
        case SurfaceMesh():
            yield from write_surface(record, sources.scene(record), target)
        case BrowserModel():
            _browser_model(record, sources, target)
        case CaseSummary():
            write_summary(record, sources, target)
        case PanesPicture(kind="panes"):
            _page(record, sources, target)
        case PanesPicture():
            raise UserError(
                "expected panes or a 3D view, which can be reproduced from their sources, got a capture of "
                "the whole window as on screen"
            )
        case PanesVideo():
            yield from _panes_video(record, sources, target)
        case MeasuresTable():
            yield from _measures(record, sources, target)
        case ViewVideo():
            yield from _view_video(record, sources, target)


def _series(record: EnhancedPicture, sources: Sources) -> Series:
    options = ClipOptions(
        deinterlacing=record.deinterlacing,
        stereo=record.stereo,
        calibration=record.calibration,
        bits=record.bits,
    )
    return sources.series(record.source, options)


def _enhanced(record: EnhancedPicture, series: Series, enhancer: MethodEnhancer) -> Made:
    frame = record.frame or 0
    if record.method not in METHODS or not 0 <= frame < len(series):
        raise UserError(
            f"expected one of {len(series)} frames and a known method, got {record.method} of {frame}"
        )
    return enhanced(record, series.read(frame), enhancer)


def _enhanced_video(record: EnhancedVideo, sources: Sources, target: Path) -> Steps:
    if not record.pictures:
        raise UserError("expected at least one frame, got none")
    enhancer = MethodEnhancer()

    @lru_cache(maxsize=1)
    def opened(source: Source) -> Series:
        return _series(next(one for one in record.pictures if one.source == source), sources)

    def pictures() -> Iterator[Made]:
        for picture in record.pictures:
            yield _enhanced(picture, opened(picture.source), enhancer)

    timing = opened(record.pictures[0].source).timing
    timing = replace(timing, frames_per_second=record.frames_per_second)
    if is_dicom_name(target):
        files = opened(record.pictures[0].source).sources
        yield from write_dicom_film(target, pictures(), timing, [], record.dicom or DEIDENTIFIED, files)
    else:
        yield from write_enhanced_video(target, pictures(), timing, [])


def _tuning_sheet(record: TuningSheet, sources: Sources, target: Path) -> None:
    series, frame = sources.series(record.source, replace(DEFAULTS, bits=record.bits)), record.frame or 0
    if not 0 <= frame < len(series) or not record.settings or record.columns < 1:
        raise UserError(f"expected settings, columns and one of {len(series)} frames")
    image = series.read(frame)
    mask = inside([image]) if record.pixels == "tissue" else None
    wanted = [Setting((place,), one.label, one.params) for place, one in enumerate(record.settings)]
    told = record.measured_over, record.noise_cut, record.lengths
    cells = tried(image, wanted, mask, drawn(record.pixels), *told)
    tiles = {cell.setting: tile(cell, cell.setting.label, record.undefined) for cell in cells}
    picture = contact_sheet(
        record.title, [tiles[setting] for setting in wanted], record.columns, breaks=record.breaks_labels
    )
    write_png(target, picture, record.signed, profile_of(series.sources[frame], picture))


def _render(record: Render, sources: Sources, target: Path) -> None:
    drawer, view = sources.drawer(record.renderer), _view(record, record, sources, trained=True)
    drawn = drawer.drawn(view)
    image = drawn.straight if record.background is None else with_bar(view.composed(drawn))
    write_image(target, image, replace(record, renderer=drawer.name).signed)


def _depth(record: Depth, sources: Sources, target: Path) -> None:
    """As numbers, whole ones where the record has a step, or in colours."""
    drawer = sources.drawer(record.renderer)
    depth = drawer.drawn(_seen(record, record, sources.scene(record))).depth
    said = replace(record, renderer=drawer.name)
    if record.step is not None:
        said = replace(
            said, holds=f"expected depth in steps of {record.step:g} scene units, 0 where nothing is"
        )
        write_image(target, in_steps(depth, record.step), said.signed)
        return
    if target.suffix in (".npy", ".tiff"):
        said = replace(said, holds="expected depth in scene units, 0 where nothing is")
        write_image(target, depth, said.signed)
        return
    picture, (nearest, farthest) = colored_depth(depth)
    said = replace(said, shows="expected depth", nearest=nearest, farthest=farthest)
    write_image(target, picture, said.signed)


def _render_video(record: RenderVideo, sources: Sources, target: Path) -> Steps:
    if not record.moments:
        raise UserError("expected at least one frame, got none")
    drawer = sources.drawer(record.renderer)
    seen = [_view(record, moment, sources, trained=True) for moment in record.moments]
    views = yield from map_steps(view_request.steady(seen, drawer.draw), lambda view: 0)
    frames = (with_bar(drawer.picture(view)) for view in views)
    with together(target) as place:
        written = yield from write_frames(place, frames, Timing(record.frames_per_second))
        said = replace(record, renderer=drawer.name, scale=views[0].scale, video=written)
        write_sidecar(place, said.signed)


def _observed(record: Splats | MovingSplats, scene: Scene) -> Scene:
    """What is written of it. Raises UserError."""
    return observed(scene) if record.unobserved is False else scene


def _browser_model(record: BrowserModel, sources: Sources, target: Path) -> None:
    scene = sources.scene(record)
    windows = page_windows(scene, record.tolerance, record.rounding)
    errors = [one.tracks.error for one in windows if one.tracks.error is not None]
    record = replace(record, error=max(errors, default=None))
    kind = "Reconstruction" if record.splats is None else "Splat file"
    about = f"{kind} of {record.trained_on}" if record.trained_on else kind
    about = ", ".join(filter(None, (about, far_off(record, scene.unit))))
    about = f"{about}. Grey: what no frame showed" if record.splats is None else about
    within = scene.camera_at_rest if record.ends == "image" else scene.field_in_view
    within, shown = (None, None) if record.unobserved else (within, scene.shown)
    is_even = record.ends == "even" and not record.unobserved and scene.is_finished_run
    closing = closing_radius(scene.cameras[0], record.camera) if is_even else None
    page = browser_page(
        windows, record, scene.mode, about=about, cameras=scene.cameras, within=within, shown=shown,
        closing=closing,
    )  # fmt: skip
    write_bytes(target, page)


def _view_video(record: ViewVideo, sources: Sources, target: Path) -> Steps:
    if not (record.views and record.moments):
        raise UserError("expected at least one 3D view and one frame, got none")
    drawer = sources.drawer(record.views[0].renderer)
    moments = yield from steady(view_moments(record, sources), drawer)
    pairs = zip(record.views, moments[0], strict=True)
    views = tuple(replace(one, renderer=drawer.name, scale=view.scale) for one, view in pairs)
    pages, timing = view_pages(moments, drawer), Timing(record.frames_per_second)
    with together(target) as place:
        written = yield from write_frames(place, pages, timing)
        write_sidecar(place, replace(record, views=views, video=written).signed)


def view_moments(record: ViewVideo, sources: Sources) -> list[Views]:
    """What is drawn for each of its frames."""
    return [
        tuple(_view(one, when, sources, trained=False) for one in record.views) for when in record.moments
    ]


def _view(record: DrawnRecord, moment: MomentRecord, sources: Sources, *, trained: bool) -> ViewRequest:
    """What is drawn at a moment; a difference is to the frames that the run was `trained` on, or to the
    clip's own, of which one may lie over the view."""
    view = _seen(record, moment, sources.scene(record))
    if record.view != "difference" and record.frame_share is None:
        return view
    return replace(view, reference=sources.reference(record, moment.frame, trained=trained))


def _seen(record: DrawnRecord, moment: MomentRecord, scene: Scene) -> ViewRequest:
    """Without what a difference is to."""
    return ViewRequest(
        scene,
        moment.time,
        moment.camera,
        record.view,
        supersampling=record.supersampling,
        frame_share=record.frame_share or 0.0,
        scale=record.scale,
        background=record.background or BLACK,
        unobserved=record.unobserved,
        ends=record.ends,
        near_plane=record.near if moment.near is None else moment.near,
        caption=record.caption,
    )


def drawn_panel(wanted: ViewRequest, drawer: Drawer) -> Panel:
    """With what it is of, and its scale where it has one. Raises UserError or ClipError."""
    shows = "" if wanted.kind == "color" else f"   {wanted.kind}"
    said = wanted.caption or f"Reconstruction   {wanted.scene.name}{shows}"
    return Panel(said, with_bar(drawer.picture(wanted)))


def view_pages(moments: Iterable[Views], drawer: Drawer) -> Iterator[ByteImage]:
    """A page a moment: one view as it is; two beside each other, each with what it is.

    Raises UserError or ClipError.
    """
    for views in moments:
        panels = [drawn_panel(wanted, drawer) for wanted in views]
        yield panels[0].image if len(panels) == 1 else sheet(panels)


def steady(moments: Sequence[Views], drawer: Drawer) -> Generator[int, None, tuple[Views, ...]]:
    """The same with one scale for all moments of a view, so that they can be compared.

    Yields 0, the pages made so far, after each picture that is looked at for it. Raises ClipError.
    """
    columns = []
    for column in zip(*moments, strict=True):
        held = yield from map_steps(view_request.steady(column, drawer.draw), lambda view: 0)
        columns.append(held)
    return tuple(zip(*columns, strict=True))


def _page(record: PanesPicture, sources: Sources, target: Path) -> None:
    """Panes, the 3D view, or both."""
    panels: list[Panel] = []
    if record.panes:
        maker, frame = PaneMaker(record, sources), record.frame.index
        made = maker.made(frame)
        panels += arranged([one.panel for one in made], record.arrangement)
        pairs = zip(record.panes, made, strict=True)
        said = [replace(pane, statistics=one.statistics) for pane, one in pairs]
        if record.measures:
            own = made if Sizing(record.scale, record.width) == Sizing() else maker.made(frame, Sizing())
            rows = measures_at(
                frame, record.measures, maker, own, noise_cut=record.noise_cut, lengths=record.lengths
            )
            said = [replace(pane, measured=row) for pane, row in zip(said, rows, strict=True)]
        record = replace(record, panes=tuple(said))
    views: list[ViewRecord] = []
    for one in record.views:
        drawer = sources.drawer(one.renderer)
        panels.append(drawn_panel(_view(one, one, sources, trained=False), drawer))
        views.append(replace(one, renderer=drawer.name))
    if not panels:
        raise UserError("expected panes or a 3D view, got neither")
    write_image(target, sheet(panels), replace(record, views=tuple(views)).signed, record.quality)


def _panes_video(record: PanesVideo, sources: Sources, target: Path) -> Steps:
    maker = _spanning(record, sources)
    yield from maker.measure()
    arrangement = maker.steady()
    pages = (sheet(maker.panels(frame, arrangement)) for frame in record.frames)
    timing = replace(timing_of(maker.clip, record.frames), frames_per_second=record.frames_per_second)
    with together(target) as place:
        written = yield from write_frames(place, pages, timing)
        write_sidecar(place, replace(record, arrangement=arrangement, video=written).signed)


def _measures(record: MeasuresTable, sources: Sources, target: Path) -> Steps:
    maker, rows = _spanning(record, sources), list[Row]()
    yield from maker.measure()
    for done, frame in enumerate(record.frames, start=1):
        rows += rows_at(frame, record, maker)
        yield done
    write_measures(target, rows, record)


def _spanning(record: SpanRecord, sources: Sources) -> PaneMaker:
    """Of panes at several frames, all of which the clip has."""
    maker = PaneMaker(record, sources)
    count = len(maker.clip)
    if not 0 <= record.first_frame <= record.last_frame < count:
        got = f"{record.first_frame} to {record.last_frame}"
        raise UserError(f"expected frames from 0 to {count - 1}, got {got}")
    return maker
