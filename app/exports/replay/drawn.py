"""Images, depth, videos and splat files of a model, reproduced."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from annotated_types import Interval
from pydantic import ConfigDict, TypeAdapter
from pydantic.dataclasses import dataclass

from app.errors import UserError
from app.exports.replay.recorded import Facts, again
from app.exports.replay.sources import Named, NamedRun, Sources
from app.exports.scene_splats import of_degree, splat_file
from app.files.atomic import write_bytes
from app.files.image_files import write_image
from app.files.provenance import write_sidecar
from app.files.video import Timing, write_video
from app.runs.run_clip import input_clip, run_clip
from app.runs.run_edits import unpacked
from app.scenes.color_bar import with_bar
from app.scenes.cpu_rendering import Draw, colored_depth
from app.scenes.photos import PhotoRequest
from app.scenes.renderers import Renderer, drawer
from app.scenes.scene import Scene, open_scene
from app.scenes.view_kinds import Scale, ViewKind
from app.scenes.view_request import ViewRequest
from renderer.camera import Camera
from renderer.clip import Clip


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class EditsFacts:
    """Which Gaussians were left out, as edits.json has them."""

    deleted: str
    hidden: str


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class SceneFacts:
    """Which model: of a run, or of a file of splats."""

    run: NamedRun | None = None
    splats: Named | None = None
    edits: EditsFacts | None = None


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class ViewFacts:
    """When, and from where it is seen."""

    time: float
    camera: dict[str, Any]
    near: float
    frame: int | None = None


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class RenderFacts:
    """What draws it."""

    renderer: str
    background: tuple[float, float, float] | None = (0.0, 0.0, 0.0)
    """None: alpha says where nothing is."""
    view: ViewKind = "color"
    scale: Scale | None = None
    supersampling: Annotated[int, Interval(ge=1, le=16)] = 1


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class VideoFacts:
    """What it takes to draw all frames."""

    frames_per_second: float
    moments: tuple[Facts, ...]


@dataclass(frozen=True, config=ConfigDict(extra="ignore"))
class MomentFacts:
    """When, and with colours by direction to which degree; None: as the model has them."""

    time: float
    sh_degree: Annotated[int, Interval(ge=0, le=3)] | None = None


SCENE, VIEW, RENDER = TypeAdapter(SceneFacts), TypeAdapter(ViewFacts), TypeAdapter(RenderFacts)
VIDEO, MOMENT = TypeAdapter(VideoFacts), TypeAdapter(MomentFacts)


def scene_of(facts: Facts, sources: Sources) -> Scene:
    """Raises UserError or pydantic.ValidationError."""
    named = SCENE.validate_python(facts)
    scene = _whole(named, sources)
    if named.edits is None:
        return scene
    edits = unpacked(named.edits.deleted, named.edits.hidden, len(scene.model), sources.file)
    return replace(scene, model=edits.applied(scene.model))


def _whole(named: SceneFacts, sources: Sources) -> Scene:
    """Without edits, whatever has been edited since."""
    if named.run is not None:
        return open_scene(sources.find_run(named.run).path, as_trained=True)
    if named.splats is not None:
        return open_scene(sources.find(named.splats))
    raise UserError(f"expected the run or splat file it was made from, got neither: {sources.file}")


def drawer_of(facts: Facts) -> tuple[Draw, str]:
    """The kind of renderer that drew, as it is here. Raises UserError or pydantic.ValidationError."""
    said = RENDER.validate_python(facts)
    kinds: dict[str, Renderer] = {"OpenGL": "gl", "float64": "reference"}
    return drawer(next((kind for word, kind in kinds.items() if said.renderer.startswith(word)), "cpu"))


def remake_render(facts: Facts, sources: Sources, target: Path) -> str:
    """Raises UserError, ClipError or pydantic.ValidationError."""
    (draw, name), view = drawer_of(facts), view_of(facts, sources, trained=True)
    drawn = view.drawn(draw)
    if RENDER.validate_python(facts).background is None:
        write_image(target, drawn.straight, again(facts))
    else:
        write_image(target, with_bar(view.composed(drawn)), again(facts))
    return name


def view_of(facts: Facts, sources: Sources, *, trained: bool) -> ViewRequest:
    """What the facts say that is drawn; a difference is to the photos that the run was `trained` on, or to
    the clip's own. Raises UserError, ClipError or pydantic.ValidationError."""
    said, seen = RENDER.validate_python(facts), VIEW.validate_python(facts)
    view = ViewRequest(
        scene_of(facts, sources),
        seen.time,
        _camera(seen),
        supersampling=said.supersampling,
        scale=said.scale,
        near_plane=seen.near,
    )
    if said.view != "difference":
        return view.of_kind(said.view)
    return view.of_kind("difference", _photo(_photos(facts, sources, trained=trained), seen.frame))


def at(view: ViewRequest, facts: Facts) -> ViewRequest:
    """The same at the moment of the facts. Raises UserError or pydantic.ValidationError."""
    seen = VIEW.validate_python(facts)
    photo = _photo(view.photo.clip, seen.frame) if isinstance(view.photo, PhotoRequest) else None
    return replace(view, time=seen.time, camera=_camera(seen), near_plane=seen.near, photo=photo)


def _photo(photos: Clip, frame: int | None) -> PhotoRequest:
    """Raises UserError for a frame that they do not have."""
    if frame is None or not 0 <= frame < len(photos):
        raise UserError(f"expected a difference to one of {len(photos)} frames, got {frame}")
    return PhotoRequest(photos, frame)


def _photos(facts: Facts, sources: Sources, *, trained: bool) -> Clip:
    """Raises UserError, ClipError or pydantic.ValidationError."""
    run = SCENE.validate_python(facts).run
    if run is None:
        raise UserError(f"expected the run of a difference, got none: {sources.file}")
    record = sources.find_run(run).record()
    clip = run_clip(record)
    return input_clip(clip, record) if trained else clip


def remake_depth(facts: Facts, sources: Sources, target: Path) -> str:
    """As numbers or in colours. Raises UserError or pydantic.ValidationError."""
    draw, name = drawer_of(facts)
    depth = view_of(facts | {"view": "color"}, sources, trained=True).drawn(draw).depth
    write_image(target, depth if target.suffix == ".npy" else colored_depth(depth)[0], again(facts))
    return name


def remake_video(facts: Facts, sources: Sources, target: Path) -> str:
    """Raises UserError, ClipError or pydantic.ValidationError."""
    video = VIDEO.validate_python(facts)
    if not video.moments:
        raise UserError(f"expected at least one frame, got none: {sources.file}")
    draw, name = drawer_of(facts)
    view = view_of(facts | video.moments[0], sources, trained=True)
    frames = (with_bar(at(view, moment).picture(draw)) for moment in video.moments)
    write_video(target, frames, Timing(video.frames_per_second))
    write_sidecar(target, again(facts))
    return name


def remake_splats(facts: Facts, sources: Sources, target: Path) -> None:
    """Raises UserError or pydantic.ValidationError."""
    said = MOMENT.validate_python(facts)
    try:
        scene = of_degree(scene_of(facts, sources), said.sh_degree)
    except ValueError as error:
        got = f"{said.sh_degree} for {error}: {sources.file}"
        raise UserError(f"expected a degree that holds the whole model, got {got}") from error
    write_bytes(target, splat_file(scene, said.time, again(facts)))


def _camera(view: ViewFacts) -> Camera:
    """Raises UserError for what is none."""
    try:
        return Camera.from_json(view.camera)
    except (KeyError, TypeError, ValueError) as error:
        raise UserError(f"expected a camera in the provenance, got a damaged one: {error}") from error
