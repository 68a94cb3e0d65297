"""The tuning grid of the window: what is varied, the cells tried so far, and the work off the thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from app.enhancement.contact_sheet import small
from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.enhancement.parameter_grid import Axis, Measures, Setting, measured, ranked, working_order
from app.gui.views.picture_view import PictureView
from enhance.image import BoolImage
from enhance.ridges import field_of_view, vessel_mask
from renderer.clip import ByteImage

THUMB_WIDTH = 320


@dataclass(frozen=True)
class Choice:
    """One parameter to vary, as chosen; an empty name: none."""

    name: str = ""
    first: float = 0.0
    last: float = 1.0
    count: int = 4

    def axis(self, *, whole: bool) -> Axis:
        """`count` values with both ends; fewer where only whole numbers do."""
        values = [round(float(value), 6) for value in np.linspace(self.first, self.last, self.count)]
        return Axis(self.name, tuple(dict.fromkeys(map(round, values) if whole else values)))


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


@dataclass
class Tuning:
    """A part of the state: tuning actions change it, drawing reads it."""

    shown: bool = False
    choices: tuple[Choice, Choice] = (Choice("d_factor", 0.0, 2.0, 4), Choice("p", 0.0, 1.0, 3))
    sort: str = ""
    """A measure, the best first; empty: as varied."""
    grid: Grid | None = None
    running: bool = False
    cells: dict[Setting, GridCell] = field(default_factory=dict)
    chosen: Setting | None = None
    """Looked at as it is."""
    look: GridCell | None = None
    """The newest cell that was made as it is."""
    view: PictureView = field(default_factory=PictureView)

    def renewed(self) -> Tuning:
        """With the same choices, for another clip."""
        return Tuning(self.shown, self.choices, self.sort)

    @property
    def request(self) -> CellRequest | None:
        """What is wanted next: the cell that is looked at, else the next of the grid."""
        if self.grid is None:
            return None
        if self.chosen is not None and not self.is_looked_at:
            return CellRequest(self.grid, self.chosen, whole=True)
        if not self.running:
            return None
        setting = next((one for one in working_order(self.grid.settings) if one not in self.cells), None)
        return CellRequest(self.grid, setting, whole=False) if setting is not None else None

    @property
    def is_looked_at(self) -> bool:
        """The cell that was chosen is there as it is."""
        wanted = (self.grid, self.chosen)
        return self.look is not None and (self.look.request.grid, self.look.request.setting) == wanted

    @property
    def in_order(self) -> tuple[Setting, ...]:
        """The settings as shown: those not yet tried keep their places at the end of a ranking."""
        settings = self.grid.settings if self.grid is not None else ()
        if not self.sort:
            return settings
        done = [one for one in settings if one in self.cells]
        best = ranked([self.cells[one].measures for one in done], self.sort)
        return *(done[place] for place in best), *(one for one in settings if one not in self.cells)


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
        if self._masks is None or self._masks[0] is not pictures.photo:
            view = field_of_view(pictures.photo)
            self._masks = pictures.photo, view, vessel_mask(pictures.photo, tissue_mask=view)
        photo, view, vessels = self._masks
        measures = measured(pictures.enhanced, photo, vessels, view, pictures.milliseconds)
        image = pictures.enhanced if request.whole else small(pictures.enhanced, THUMB_WIDTH)
        yield GridCell(request, image, measures)
