"""What the 3D view shows, from where, and of when. A part of the state."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from app.gui.state.camera_list import CameraList
from app.gui.state.second import Second
from app.gui.state.viewer import Viewer
from app.gui.work.baking import Baked
from app.scenes.scene import Scene
from app.scenes.view_kinds import ViewKind
from app.scenes.view_request import ViewRequest
from app.scenes.viewing import View


@dataclass
class ShownScene:
    """View, camera and path actions change it; drawing reads it."""

    model: Scene | None = None
    view: View | None = None
    """The newest picture of it that the processor drew."""
    baked: Baked | None = None
    """Keyframes for the graphics card, of `model` or of one before it; more to come while they are None."""
    kind: ViewKind = "color"
    size: tuple[int, int] = (0, 0)
    """Pixels of the 3D view, as last laid out; (0, 0) while it is hidden."""
    dragged: bool = False
    viewer: Viewer = field(default_factory=Viewer)
    cameras: CameraList = field(default_factory=CameraList)
    second: Second = field(default_factory=Second)
    linked: bool = True
    """The 3D view follows the clip's frame."""
    own_time: float = 0.0
    """In [0, 1]; used when not linked."""
    processor_draws: bool = True
    """The numba rasteriser draws the 3D view, since there is no graphics card, or OpenGL is slower."""
    drawn_by: str = ""
    """Why, for the tooltip."""

    def beside(self, first: ViewRequest) -> ViewRequest | None:
        """The second reconstruction at the moment of `first` through its camera; None without one.

        A photo is of the first one's frames: where the second has others, its difference to them is none.
        """
        shown = self.second.shown
        if shown is None:
            return None
        same = (shown.first, shown.cameras) == (first.scene.first, first.scene.cameras)
        if first.kind == "difference" and not same:
            return replace(first, scene=shown, kind="color", photo=None)
        return replace(first, scene=shown)
