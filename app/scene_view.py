"""A scene as one kind of view shows it, at any moment."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace

from app.drawing import Draw, Drawn
from app.errors import UserError
from app.evaluate import run_clip
from app.moments import Moment
from app.run_folder import RunFolder
from app.scene import Scene, is_splat_file
from app.training import input_clip
from app.views import (
    EXPLAINED,
    SHAPES,
    Composed,
    Scale,
    ViewKind,
    composed,
    has_scale,
    holding,
    splats_for,
    spread,
)
from renderer.camera import Camera
from renderer.clip import Clip
from renderer.near_plane import near_plane


@dataclass(frozen=True, eq=False)
class SceneView:
    """What is drawn, by what."""

    scene: Scene
    kind: ViewKind
    draw: Draw
    photos: Clip | None = None
    """What a difference is to."""
    scale: Scale | None = None
    """Of its values; None: that which holds those of each picture."""

    def drawn(self, time: float, camera: Camera, near: float) -> Drawn:
        """The splats of this kind; `near` in scene units."""
        splats = splats_for(self.kind, self.scene.model, time, camera)
        return self.draw(splats, camera, near, self.scene.mode, SHAPES[self.kind])

    def composed(self, drawn: Drawn, frame: int | None) -> Composed:
        """The picture of these; a difference is to the photo of `frame`. Raises UserError or ClipError."""
        photo = None
        if self.photos is not None:
            if frame is None or not 0 <= frame < len(self.photos):
                raise UserError(f"expected a difference to one of {len(self.photos)} frames, got {frame}")
            photo = self.photos.read_image(frame)
        return composed(self.kind, drawn, self.scene.unit, photo, self.scale)

    def at(self, moment: Moment) -> Composed:
        """Raises UserError or ClipError."""
        near = near_plane(self.scene.model, moment.camera)
        return self.composed(self.drawn(moment.time, moment.camera, near), moment.frame)

    def steady(self, moments: Sequence[Moment]) -> SceneView:
        """With one scale for all of these moments, so that they can be compared."""
        if not has_scale(self.kind):
            return self
        scales = [self.at(moment).scale for moment in spread(moments)]
        return replace(self, scale=holding([scale for scale in scales if scale is not None]))


def add_flag(parser: argparse.ArgumentParser) -> None:
    """Which kind of view is drawn."""
    parser.add_argument(
        "--view",
        choices=EXPLAINED,
        default="color",
        help="what pictures and videos show, with a scale where that is a quantity, one for all of a video; "
        "difference: to the photos that the run was trained on (default color)",
    )


def asked_for(flags: argparse.Namespace, scene: Scene, draw: Draw) -> SceneView:
    """Raises UserError for a difference where there are no photos."""
    return SceneView(scene, flags.view, draw, _photos(flags) if flags.view == "difference" else None)


def _photos(flags: argparse.Namespace) -> Clip:
    """What each frame of a run should look like. Raises UserError where there is none."""
    if is_splat_file(flags.scene) or flags.camera or flags.path or flags.time is not None:
        raise UserError("--view difference: expected frames of a run from its own cameras, which have photos")
    record = RunFolder(flags.scene).record()
    camera = record.camera(0)
    if flags.size and not camera.has_shape(*flags.size):
        raise UserError(
            f"--view difference: expected a --size of the photos' shape, {camera.width} {camera.height}, "
            f"got {flags.size[0]} {flags.size[1]}"
        )
    return input_clip(run_clip(record), record)
