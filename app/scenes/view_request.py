"""A view of a scene by value: what a window, an export, a command and a replay ask of a renderer."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.files.records import extended
from app.scenes.backgrounds import Background
from app.scenes.cpu_rendering import Draw, DrawOptions
from app.scenes.free_camera import FreeView
from app.scenes.records import DrawnRecord, Ends, MomentRecord, ViewRecord
from app.scenes.scene import Scene
from app.scenes.supersampling import supersampled
from app.scenes.surfaces import drawing_surface
from app.scenes.view_kinds import (
    LOOKED_AT,
    SHAPES,
    Composed,
    Scale,
    ViewKind,
    composed,
    facing,
    has_scale,
    holding,
    laid_over,
    splats_for,
)
from renderer.camera import Camera
from renderer.clip import ByteImage, Clip
from renderer.closing import closed, closing_radius
from renderer.evenly import evenly
from renderer.in_view import InView
from renderer.rasterize.rendered import Rendered
from renderer.splats import Splats
from renderer.unobserved import GREY


@dataclass(frozen=True)
class FrameRequest:
    """A clip's frame, to lay over the 3D view."""

    clip: Clip
    frame: int

    @property
    def image(self) -> ByteImage:
        """(H, W, 3), read each time: a clip's frames fill the memory. Raises ClipError."""
        return self.clip.read_image(self.frame)


@dataclass(frozen=True, eq=False)
class FrameImage:
    """With the request that it answers."""

    request: FrameRequest
    image: ByteImage
    """(H, W, 3)."""


def read_frame(request: FrameRequest) -> Iterator[FrameImage]:
    """Off the window's thread. Raises ClipError: the file is gone or damaged."""
    yield FrameImage(request, request.image)


@dataclass(frozen=True)
class ViewRequest:
    """Everything that a picture depends on, but for what draws it."""

    scene: Scene
    time: float
    camera: Camera
    kind: ViewKind = "color"
    reference: FrameImage | FrameRequest | None = None
    """Of the same frame, where the view is the difference to it, or it lies over the view; read when it is
    needed, or before."""
    frame_share: float = 0.0
    """Of the reference over a view that is no difference to it, in [0, 1]."""
    supersampling: int = 1
    """Drawn with so many times as many pixels each way, and averaged."""
    scale: Scale | None = None
    """Of its values; None: that which holds those of this picture."""
    background: Background = GREY
    """Where nothing was observed."""
    unobserved: bool = False
    """Drawn with what no frame shows: what lies beyond those of a camera at rest, and Gaussians behind tissue
    in all of them."""
    ends: Ends = "even"
    """How tissue does in views from elsewhere than the endoscope was."""
    near_plane: float | None = None
    """In scene units; None: that of the scene."""
    caption: str | None = None
    """Above it on a page; None: its name."""
    reduced: bool = False
    """Drawn with fewer pixels than the screen has, to keep up with the hand."""

    @classmethod
    def of_frame(cls, scene: Scene, frame: int) -> ViewRequest:
        """That frame as the clip's camera took it: moment, pose, lens, pixels."""
        return cls(scene, scene.time(frame), scene.cameras[frame])

    @classmethod
    def of_clip_frame(cls, scene: Scene, frame: int) -> ViewRequest:
        """That frame of the whole clip; of those before and after the scene's own, the nearest."""
        return cls.of_frame(scene, min(max(frame - scene.start, 0), len(scene.cameras) - 1))

    @classmethod
    def fitted(cls, scene: Scene, time: float, free: FreeView | None, size: tuple[int, int]) -> ViewRequest:
        """Of (width, height) pixels at `time` in [0, 1]: the free view, or that of the clip's camera.

        The frame's whole field stays in view, whatever the shape of the view.
        """
        camera = scene.camera_at(time) if free is None else free.camera
        return cls(scene, time, camera.fitted(*size))

    @property
    def near(self) -> float:
        """The near plane in scene units."""
        return self.scene.near if self.near_plane is None else self.near_plane

    @property
    def within(self) -> InView | None:
        """Beyond which nothing is drawn; None: that changes nothing, or is not wanted. From where the camera
        was, the rim of its field is part of the image."""
        camera = None if self.unobserved else self.scene.camera_at_rest
        if camera is None or self.camera.sees_only(camera):
            return None
        is_own = self.camera.has_pose_of(camera)
        return camera if is_own or self.ends == "image" else self.scene.field_in_view

    @property
    def leaves_out(self) -> bool:
        """Gaussians that no frame shows: from where the endoscope was, their rims are part of the image."""
        is_free = not self.camera.has_pose_of(self.scene.camera_at(self.time))
        return is_free and not self.unobserved and SHAPES[self.kind] == "soft"

    @property
    def closing(self) -> int:
        """Pixels to each side over which gaps are closed; 0: it is drawn as it is. Values are, and so is what
        is not known to be of an endoscope: a file, or a preview."""
        scene = self.scene
        if not (self.leaves_out and self.ends == "even" and self.kind == "color" and scene.is_finished_run):
            return 0
        return max(1, round(closing_radius(scene.cameras[0], self.camera)))

    @property
    def so_far(self) -> ViewRequest:
        """The same for a window, which does not wait until it is known what no frame shows: all till then."""
        waits = self.leaves_out and self.scene.tells_shown and self.scene.shown_so_far is None
        return replace(self, unobserved=True) if waits else self

    @property
    def splats(self) -> Splats:
        """Of its kind and time, those that are not drawn with an opacity of 0."""
        splats = splats_for(self.kind, self.scene.model, self.time)
        if not self.leaves_out or self.scene.shown is None:
            return splats
        return replace(splats, opacities=np.where(self.scene.shown, splats.opacities, np.float32(0)))

    @property
    def frame(self) -> int:
        """Of the scene's frames the nearest."""
        return self.scene.frame_at(self.time)

    def of_kind(self, kind: ViewKind, reference: FrameImage | FrameRequest | None = None) -> ViewRequest:
        """The same camera and time shown otherwise; a difference without its reference stays in colour."""
        if kind == "difference":
            return self if reference is None else replace(self, kind=kind, reference=reference)
        return replace(self, kind=kind)

    def scaled(self, scale: float) -> ViewRequest:
        """The same view with fewer pixels."""
        width = max(1, round(self.camera.width * scale))
        height = max(1, round(self.camera.height * scale))
        return replace(self, camera=self.camera.resized(width, height), reduced=True)

    def drawn(self, draw: Draw) -> Rendered:
        """The splats of its kind, as the scene was trained to be drawn."""
        if self.kind == "surface":
            draw = drawing_surface(self.scene, self.time)
        options = DrawOptions(self.near, self.scene.mode, SHAPES[self.kind], self.within)
        return closed(supersampled(draw, self.supersampling)(self.splats, self.camera, options), self.closing)

    def composed(self, drawn: Rendered) -> Composed:
        """The picture that is asked for, of its splats drawn in their shape. Raises ClipError."""
        reference = self.reference.image if self.reference else None
        unit, since = self.scene.unit, self.scene.motion_since
        drawn = facing(drawn, self.camera) if self.kind == "normals" else drawn
        made = composed(self.kind, drawn, unit, reference, self.scale, self.background, since)
        if reference is None or not self.frame_share:
            return made
        return replace(made, image=laid_over(made.image, reference, self.frame_share))

    def picture(self, draw: Draw) -> Composed:
        """Raises ClipError for a reference, UserError where it cannot be drawn."""
        return self.composed(self.drawn(draw))


def steady(views: Sequence[ViewRequest], draw: Draw) -> Generator[ViewRequest, None, tuple[ViewRequest, ...]]:
    """The same with one scale for all, so that they can be compared; as they are where they have one.

    Yields each view that is looked at for it. Raises ClipError or UserError.
    """
    if views[0].scale is not None:
        return tuple(views)
    scales = []
    for view in evenly(views, LOOKED_AT) if has_scale(views[0].kind) else ():
        scales.append(view.picture(draw).scale)
        yield view
    found = [scale for scale in scales if scale is not None]
    scale = holding(found) if found else None
    return tuple(replace(view, scale=scale) for view in views)


def view_record(view: ViewRequest, renderer: str) -> ViewRecord:
    """What an export says of it, with the name of what draws it: its own run and clip, which need not be
    those of the pictures beside it."""
    moment = {"time": view.time, "camera": view.camera, "frame": view.frame, "start": view.scene.first}
    return extended(ViewRecord, drawn_record(view, renderer), **moment)


def drawn_record(view: ViewRequest, renderer: str) -> DrawnRecord:
    """What is so at every moment of a video: the model, and how it is drawn."""
    return extended(
        DrawnRecord,
        view.scene.record,
        iteration=view.scene.iteration,
        near=view.near,
        background=view.background,
        unobserved=view.unobserved,
        ends=view.ends,
        renderer=renderer,
        supersampling=view.supersampling,
        view=view.kind,
        frame_share=view.frame_share or None,
        scale=view.scale,
        caption=view.caption or caption_of(view),
    )


def caption_of(view: ViewRequest) -> str:
    """Of what, from which frames, in which view where that is not how it looks, and what lies over it."""
    record, shows = view.scene.record, "" if view.kind == "color" else view.kind
    frames = f"from {record.trained_on}" if record.trained_on else ""
    what = "Reconstruction" if view.scene.is_of_run else "Splat file"
    over = f"frame {100 * view.frame_share:.0f} % over it" if view.frame_share else ""
    return "   ".join(filter(None, (f"{what} {view.scene.name}", frames, shows, over)))


def moment_record(view: ViewRequest) -> MomentRecord:
    """When, and from where it is seen."""
    return MomentRecord(time=view.time, camera=view.camera, frame=view.frame)
