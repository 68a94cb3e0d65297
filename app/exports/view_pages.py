"""What the 3D view shows, and the second one beside it, as panels of an image and as pages of a video."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence

from app.exports.page import Panel, sheet
from app.files.stepping import map_steps
from app.scenes import view_request
from app.scenes.color_bar import with_bar
from app.scenes.drawer import Drawer
from app.scenes.view_request import ViewRequest
from renderer.clip import ByteImage

Views = tuple[ViewRequest, ...]
"""Of one moment: the 3D view, and the second one where there is one."""


def drawn_panel(wanted: ViewRequest, drawer: Drawer) -> Panel:
    """By the name of its run or file, with its scale where it has one. Raises UserError or ClipError."""
    shows = "" if wanted.kind == "color" else f"   {wanted.kind}"
    return Panel(f"Reconstruction   {wanted.scene.name}{shows}", with_bar(drawer.picture(wanted)))


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
