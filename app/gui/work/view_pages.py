"""What the 3D view shows, and the second one beside it, as panels of a picture and as pages of a video."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
from typing import Any

from app.color_bar import with_bar
from app.gui.work.page import Panel, sheet
from app.gui.work.photos import PhotoRequest, read_photo
from app.gui.work.viewing import View, ViewRequest, draw_view, lasting_facts, moment_facts
from app.views import Composed, ViewKind, has_scale, holding, spread
from renderer.clip import ByteImage, Clip

Views = tuple[ViewRequest, ...]
"""Of one moment: the 3D view, and the second one where there is one."""


def view_panel(name: str, image: ByteImage, kind: ViewKind) -> Panel:
    """A model, by the name of its run or file."""
    shows = "" if kind == "color" else f"   {kind}"
    return Panel(f"Reconstruction   {name}{shows}", image)


def view_page(panels: Sequence[Panel]) -> ByteImage:
    """One view as it is; two beside each other, each with what it is."""
    return panels[0].image if len(panels) == 1 else sheet(panels)


def drawn_panel(wanted: ViewRequest) -> Panel:
    """With its scale, where it has one."""
    view = _drawn(wanted)
    return view_panel(wanted.shown.name, with_bar(Composed(view.image, view.scale)), wanted.kind)


def view_pages(moments: Sequence[Views], photos: Clip | None) -> Iterator[ByteImage]:
    """A page a moment; `photos` are what differences are to. Raises ClipError."""
    for views in moments:
        yield view_page([drawn_panel(_with_photo(wanted, photos)) for wanted in views])


def steady(moments: Sequence[Views], photos: Clip | None) -> Generator[int, None, tuple[Views, ...]]:
    """The same with one scale for all moments of a view, so that they can be compared.

    Yields 0, the pages made so far, after each picture that is looked at for it. Raises ClipError.
    """
    columns = []
    for column in zip(*moments, strict=True):
        scales = []
        for wanted in spread(column) if has_scale(column[0].kind) else ():
            scales += [scale for scale in (_drawn(_with_photo(wanted, photos)).scale,) if scale is not None]
            yield 0
        scale = holding(scales) if scales else None
        columns.append([replace(wanted, scale=scale) for wanted in column])
    return tuple(zip(*columns, strict=True))


def video_facts(moments: Sequence[Views]) -> dict[str, Any]:
    """What a video says of them; views of one moment have one time and one camera."""
    return {
        "views": [lasting_facts(wanted) for wanted in moments[0]],
        "moments": [moment_facts(views[0]) for views in moments],
    }


def _with_photo(wanted: ViewRequest, photos: Clip | None) -> ViewRequest:
    """A difference with the photo of its frame, read only now: a clip's photos fill the memory."""
    if wanted.kind != "difference" or photos is None:
        return wanted
    frame = wanted.shown.start + wanted.shown.frame_at(wanted.time)
    (photo,) = read_photo(PhotoRequest(photos, frame))
    return replace(wanted, photo=photo)


def _drawn(wanted: ViewRequest) -> View:
    (view,) = draw_view(wanted)
    return view
