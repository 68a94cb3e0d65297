"""The tuning grid: what is varied, and the cells tried so far. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.enhancement.parameter_grid import Setting, ranked, working_order
from app.gui.session_file import Choice
from app.gui.views.picture_view import PictureView
from app.gui.work.tuning import CellRequest, Grid, GridCell


@dataclass
class Tuning:
    """Tuning actions change it; drawing reads it."""

    shown: bool = False
    asked: bool = False
    """Its panel is to come to the front."""
    choices: tuple[Choice, Choice] = (Choice("d_factor", 3.0, 0.33, 4), Choice("p", 0.0, 1.0, 3))
    sort: str = ""
    """A measure, the best first; empty: as varied."""
    grid: Grid | None = None
    running: bool = False
    cells: dict[Setting, GridCell] = field(default_factory=dict)
    chosen: Setting | None = None
    """The cell that fills the panel, at full size."""
    whole: GridCell | None = None
    """The newest cell that was made at full size."""
    view: PictureView = field(default_factory=PictureView)
    """Of that cell and the original beside it."""
    size: float = 1.0
    """Of the tiles; at 1 all columns are in sight."""
    columns: int = 1
    """As last laid out."""
    in_sight: bool = False
    """The panel is drawn in this frame."""

    def renewed(self) -> Tuning:
        """With the same choices, for another clip."""
        return Tuning(self.shown, choices=self.choices, sort=self.sort, size=self.size)

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
        """The chosen cell is there at full size."""
        wanted = (self.grid, self.chosen)
        return self.whole is not None and (self.whole.request.grid, self.whole.request.setting) == wanted

    @property
    def flows(self) -> bool:
        """Rows are as long as there is room: no two parameters give them their length."""
        return bool(self.sort) or self.grid is None or len(self.grid.settings[0].places) < 2

    @property
    def in_order(self) -> tuple[Setting, ...]:
        """The settings as shown: those not yet tried keep their places at the end of a ranking."""
        settings = self.grid.settings if self.grid is not None else ()
        if not self.sort:
            return settings
        done = [one for one in settings if one in self.cells]
        best = ranked([self.cells[one].measures for one in done], self.sort)
        return *(done[place] for place in best), *(one for one in settings if one not in self.cells)
