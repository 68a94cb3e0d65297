"""The tuning grid of the window: its cells, tried off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.enhancement.measures import Measures, Original
from app.enhancement.parameter_grid import Setting
from app.gui.work.thumbnails import shrunk
from renderer.clip import ByteImage

TILE = (480, 960)
"""Pixels across and down of a tile at most; one of a smaller picture is as large as that."""


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


class CellMaker:
    """Answers CellRequests with the window's own enhancement; remembers the picture and its masks."""

    def __init__(self) -> None:
        self._pictures = PictureMaker()
        self._known: tuple[Original, ByteImage] | None = None
        """The original, and as it is in the grid: one for all cells."""

    def make(self, request: CellRequest) -> Iterator[GridCell]:
        """Raises ClipError or ImageError."""
        wanted = request.grid.picture.with_params(request.setting.params)
        pictures = list(self._pictures.make(wanted))[-1]
        assert pictures.enhanced is not None
        if self._known is None or self._known[0].image is not pictures.original:
            self._known = Original.of(pictures.original), shrunk(pictures.original, *TILE)
        frame, small = self._known
        measures = frame.measures(pictures.enhanced, pictures.milliseconds)
        image, original = pictures.enhanced, pictures.original
        if not request.whole:
            image, original = shrunk(image, *TILE), small
        yield GridCell(request, image, measures, original, frame.own)
