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

THUMB_WIDTH = 320


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


class CellMaker:
    """Answers CellRequests with the window's own enhancement; remembers the picture and its masks."""

    def __init__(self) -> None:
        self._pictures = PictureMaker()
        self._masks: tuple[ByteImage, BoolImage, BoolImage] | None = None

    def make(self, request: CellRequest) -> Iterator[GridCell]:
        """Raises ClipError or ImageError."""
        wanted = request.grid.picture.with_params(request.setting.params)
        pictures = list(self._pictures.make(wanted))[-1]
        assert pictures.enhanced is not None
        if self._masks is None or self._masks[0] is not pictures.original:
            view = field_of_view(pictures.original)
            self._masks = pictures.original, view, vessel_mask(pictures.original, tissue_mask=view)
        original, view, vessels = self._masks
        measures = measured(pictures.enhanced, original, vessels, view, pictures.milliseconds)
        image = pictures.enhanced if request.whole else small(pictures.enhanced, THUMB_WIDTH)
        yield GridCell(request, image, measures)
