"""Pictures, depth and videos of models, of their records."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

from app.errors import UserError
from app.exports.records import Depth, Render, RenderVideo, ViewVideo
from app.exports.sources import Sources
from app.exports.view_pages import Views, steady, view_pages
from app.files.atomic import together
from app.files.image_files import write_image
from app.files.provenance import write_sidecar
from app.files.stepping import map_steps
from app.files.timing import Timing
from app.files.video import write_frames
from app.scenes import view_request
from app.scenes.color_bar import with_bar
from app.scenes.cpu_rendering import colored_depth
from app.scenes.records import DrawnRecord, MomentRecord, ViewRecord
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest


def make_render(record: Render, sources: Sources, target: Path) -> None:
    """Raises UserError or ClipError."""
    drawer, view = sources.drawer(record.renderer), view_of(record, sources, trained=True)
    drawn = drawer.drawn(view)
    image = drawn.straight if record.background is None else with_bar(view.composed(drawn))
    write_image(target, image, replace(record, renderer=drawer.name).signed_without_hour)


def make_depth(record: Depth, sources: Sources, target: Path) -> None:
    """As numbers or in colours, as the suffix says. Raises UserError."""
    drawer = sources.drawer(record.renderer)
    depth = drawer.drawn(_seen(record, record, sources.scene(record))).depth
    record = replace(record, renderer=drawer.name)
    if target.suffix == ".npy":
        record = replace(record, holds="expected depth in scene units, 0 where nothing is")
        write_image(target, depth, record.signed_without_hour)
        return
    picture, (nearest, farthest) = colored_depth(depth)
    record = replace(record, shows="expected depth", nearest=nearest, farthest=farthest)
    write_image(target, picture, record.signed_without_hour)


def make_video(record: RenderVideo, sources: Sources, target: Path) -> Generator[int, None, None]:
    """Raises UserError or ClipError."""
    if not record.moments:
        raise UserError("expected at least one frame, got none")
    drawer, scene = sources.drawer(record.renderer), sources.scene(record)
    views = [
        _at(_seen(record, moment, scene, moment.near), record, moment, sources, trained=True)
        for moment in record.moments
    ]
    held = yield from map_steps(view_request.steady(views, drawer.draw), lambda view: 0)
    record = replace(record, renderer=drawer.name, scale=held[0].scale)
    frames = (with_bar(drawer.picture(view)) for view in held)
    with together(target) as place:
        written = yield from write_frames(place, frames, Timing(record.frames_per_second))
        write_sidecar(place, replace(record, video=written).signed_without_hour)


def make_view_video(record: ViewVideo, sources: Sources, target: Path) -> Generator[int, None, None]:
    """The 3D view, or both. Raises UserError or ClipError."""
    if not (record.views and record.moments):
        raise UserError("expected at least one 3D view and one frame, got none")
    drawer = sources.drawer(record.views[0].renderer)
    scenes = [sources.scene(one) for one in record.views]

    def views_at(moment: MomentRecord) -> Views:
        pairs = zip(record.views, scenes, strict=True)
        return tuple(
            _at(_seen(one, moment, scene), one, moment, sources, trained=False) for one, scene in pairs
        )

    moments = yield from steady([views_at(moment) for moment in record.moments], drawer)
    views = tuple(
        replace(one, renderer=drawer.name, scale=held.scale)
        for one, held in zip(record.views, moments[0], strict=True)
    )
    with together(target) as place:
        written = yield from write_frames(
            place, view_pages(moments, drawer), Timing(record.frames_per_second)
        )
        write_sidecar(place, replace(record, views=views, video=written).signed)


def view_of(record: ViewRecord, sources: Sources, *, trained: bool) -> ViewRequest:
    """What the record says that is drawn; a difference is to the photos that the run was `trained` on, or to
    the clip's own. Raises UserError or ClipError."""
    return _at(_seen(record, record, sources.scene(record)), record, record, sources, trained=trained)


def _seen(record: DrawnRecord, moment: MomentRecord, scene: Scene, near: float | None = None) -> ViewRequest:
    """Without what a difference is to."""
    return ViewRequest(
        scene,
        moment.time,
        moment.camera,
        record.view,
        supersampling=record.supersampling,
        scale=record.scale,
        near_plane=record.near if near is None else near,
    )


def _at(
    view: ViewRequest, record: DrawnRecord, moment: MomentRecord, sources: Sources, *, trained: bool
) -> ViewRequest:
    """With what a difference is to."""
    if record.view != "difference":
        return view
    return replace(view, photo=sources.photo(record, moment.frame, trained=trained))
