"""What of the motion of tissue the poses of a camera are told apart from, and how that is said."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

TissueMotion = Literal["found", "not found", "not sought"]

_TOGETHER = "what all of the tissue does together counts as camera motion"
TISSUE: Final[Mapping[TissueMotion, str]] = {
    "found": "tissue moves in two ways, such as breathing and a pull, which do not count as camera motion",
    "not found": f"motions of the tissue were sought and not found: {_TOGETHER}",
    "not sought": f"motions of the tissue were not sought, as too little shows any: {_TOGETHER}",
}
