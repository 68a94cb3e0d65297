"""The tuning grid of the window: its cells, tried off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from app.enhancement.contact_sheet import small
from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.enhancement.parameter_grid import Measures, Setting, measured
from enhance.image import BoolImage
from enhance.ridges import field_of_view, vessel_mask
from renderer.clip import ByteImage

THUMB_WIDTH = 480


@dataclass(frozen=True, eq=False)
class Grid:
    """All settings of one grid and the picture that they are tried on."""

    picture: PictureRequest
    """Its parameters are those of the window when the grid was begun."""
    settings: tuple[Setting, ...]
    columns: int


@dataclass(frozen=True)
class CellRequest:
    """One cell of a grid, small for the grid or as it is."""

    grid: Grid
    setting: Setting
    whole: bool


@dataclass(frozen=True, eq=False)
class GridCell:
    request: CellRequest
    image: ByteImage
    """(H, W, 3)."""
    measures: Measures
    original: ByteImage
    """In the same size."""
    before: Measures
    """Of the original."""


@dataclass(frozen=True, eq=False)
class _Known:
    """What all cells of a grid have in common."""

    original: ByteImage
    small: ByteImage
    view: BoolImage
    vessels: BoolImage
    measures: Measures


class CellMaker:
    """Answers CellRequests with the window's own enhancement; remembers the picture and its masks."""

    def __init__(self) -> None:
        self._pictures = PictureMaker()
        self._known: _Known | None = None

    def make(self, request: CellRequest) -> Iterator[GridCell]:
        """Raises ClipError or ImageError."""
        wanted = request.grid.picture.with_params(request.setting.params)
        pictures = list(self._pictures.make(wanted))[-1]
        assert pictures.enhanced is not None
        if self._known is None or self._known.original is not pictures.original:
            self._known = _known(pictures.original)
        known = self._known
        measures = measured(
            pictures.enhanced, known.original, known.vessels, known.view, pictures.milliseconds
        )
        image, original = pictures.enhanced, known.original
        if not request.whole:
            image, original = small(image, THUMB_WIDTH), known.small
        yield GridCell(request, image, measures, original, known.measures)


def _known(original: ByteImage) -> _Known:
    view = field_of_view(original)
    vessels = vessel_mask(original, tissue_mask=view)
    return _Known(
        original,
        small(original, THUMB_WIDTH),
        view,
        vessels,
        measured(original, original, vessels, view, 0.0),
    )
