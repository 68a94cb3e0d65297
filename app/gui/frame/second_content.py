"""What the second window shows: the chosen pane of the first one as large as it fits, and what it is."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from app.gui.drawing.label_image import label_image
from app.gui.drawing.quads import Box, Quad
from app.gui.drawing.textures import ShowsPictures
from app.gui.drawing.viewport import OnScreen, Viewport
from app.gui.state.app_state import AppState
from app.gui.state.panes import frame_share, pane
from app.gui.state.tags import Tag, cautions
from app.gui.state.view_words import frame_over, view_tags
from app.gui.views.comparison import Side
from app.gui.views.picture_view import PictureView
from app.scenes.color_bar import color_bar
from renderer.clip import ByteImage

Size = tuple[int, int]
Labels = tuple[Tag, ...]
Drawn = tuple[tuple[Quad, ...], Labels]
NOTHING: Labels = (Tag("Nothing to show"),)


class SecondContent:
    """Remembers the labels and the scale that it has made."""

    def __init__(self, ctx: moderngl.Context, textures: ShowsPictures, viewport: Viewport) -> None:
        self._ctx, self._textures, self._viewport = ctx, textures, viewport
        self._made: dict[str, tuple[object, ByteImage]] = {}

    def of(self, state: AppState, size: Size) -> tuple[tuple[Quad, ...], str]:
        """For a window of `size` pixels, with its title. Without labels it says only what could mislead."""
        name = state.second_window.pane
        drawn, tags = self._scene(state, size) if name == "3D view" else self._picture(state, name, size)
        if said := tags if state.second_window.labels else cautions(tags):
            drawn = (*drawn, self._labels(said, size))
        return drawn, tags[0].text

    def finish(self) -> None:
        """Before another context reads the textures: all of them are written."""
        self._ctx.finish()

    def _picture(self, state: AppState, side: Side, size: Size) -> Drawn:
        if state.picture.pictures is None:
            return (), NOTHING
        shown = pane(state, state.picture.pictures, side)
        view = PictureView(pixel_aspect=state.picture.view.pixel_aspect)
        place = view.place((shown.image.shape[1], shown.image.shape[0]), size)
        part = self._textures.part("second window", shown.image, place, size, (shown.zebra, shown.tint))
        if part is None:
            return (), shown.tags
        box = (part.x, part.y, part.x + part.width, part.y + part.height)
        return (Quad(part.texture, box, part),), shown.tags

    def _scene(self, state: AppState, size: Size) -> Drawn:
        """As fine as the first window draws it."""
        shown = self._viewport.show(state) if state.scene.model is not None else None
        if shown is None:
            return (), NOTHING if state.scene.model is None else view_tags(state, None)
        camera = shown.request.camera
        place = PictureView().place((camera.width, camera.height), size)
        box = (*place.pane_at(0, 0), *place.pane_at(camera.width, camera.height))
        drawn = [Quad(shown.texture, box, shown.request, (*shown.uv0, *shown.uv1))]
        if (frame := frame_over(state, shown.request)) is not None:
            share = frame_share(state, shown.request.scene)
            over = self._textures.whole("second window: frame", frame.image)
            drawn.append(Quad(over, box, frame.request, share=share))
        if shown.scale is not None:
            drawn.append(self._bar(shown, size))
        return tuple(drawn), view_tags(state, shown.request)

    def _bar(self, shown: OnScreen, size: Size) -> Quad:
        """What the colours mean, at the right edge."""
        scale, height = shown.scale, max(size[1] // 2, 1)
        assert scale is not None
        image = self._once("colours", (shown.request, size), lambda: color_bar(scale, height))
        left, top = size[0] - image.shape[1], size[1] // 4
        beside: Box = (left, top, size[0], top + image.shape[0])
        return Quad(self._textures.whole("second window: colours", image), beside, shown.request)

    def _labels(self, said: Labels, size: Size) -> Quad:
        image = self._once("labels", (said, size), lambda: label_image(said, size))
        box = (0.0, 0.0, float(image.shape[1]), float(image.shape[0]))
        return Quad(self._textures.whole("second window: labels", image), box, said)

    def _once(self, name: str, what: object, make: Callable[[], ByteImage]) -> ByteImage:
        """The one that is made already, of the same."""
        if name not in self._made or self._made[name][0] != what:
            self._made[name] = what, make()
        return self._made[name][1]
