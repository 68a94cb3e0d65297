"""The figures of the paper's Tables 1 to 3."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from app.runs.run_folder import Input


@dataclass(frozen=True)
class PaperRow:
    """One row of Tables 1 and 2: renders of a clip, from its own frames or enhanced ("Ours")."""

    clip: str
    """A word in its name."""
    frames: int | None
    """None: the paper does not say."""
    table: int
    method: str
    input: Input
    lpips: float
    dv: float
    bv: float
    dv_bv: float


PAPER: Final = (
    PaperRow("pulling", 63, 1, "EndoGaussian", "original", 0.106, 259.68, 218.77, 1.21),
    PaperRow("pulling", 63, 1, "EndoGaussian", "enhanced", 0.122, 427.55, 243.74, 1.76),
    PaperRow("pulling", 63, 2, "Deform3DGS", "original", 0.042, 651.04, 706.03, 0.93),
    PaperRow("pulling", 63, 2, "Deform3DGS", "enhanced", 0.043, 871.14, 596.63, 1.47),
    PaperRow("cutting", 156, 1, "EndoGaussian", "original", 0.102, 521.72, 487.87, 1.07),
    PaperRow("cutting", 156, 1, "EndoGaussian", "enhanced", 0.115, 741.30, 460.64, 1.61),
    PaperRow("cutting", 156, 2, "Deform3DGS", "original", 0.064, 414.71, 779.48, 0.54),
    PaperRow("cutting", 156, 2, "Deform3DGS", "enhanced", 0.068, 572.00, 560.22, 1.02),
)
SCARED: Final = (
    PaperRow("SCARED 1", None, 1, "EndoGaussian", "original", 0.2754, 1146.07, 547.67, 2.11),
    PaperRow("SCARED 1", None, 1, "EndoGaussian", "enhanced", 0.2625, 968.94, 432.26, 2.41),
    PaperRow("SCARED 2", None, 1, "EndoGaussian", "original", 0.2124, 944.91, 766.86, 1.26),
    PaperRow("SCARED 2", None, 1, "EndoGaussian", "enhanced", 0.2121, 1131.84, 657.86, 1.72),
    PaperRow("SCARED 3", None, 1, "EndoGaussian", "original", 0.4348, 895.15, 589.66, 1.55),
    PaperRow("SCARED 3", None, 1, "EndoGaussian", "enhanced", 0.4399, 1054.38, 490.86, 2.16),
    PaperRow("SCARED 6", None, 1, "EndoGaussian", "original", 0.4529, 742.05, 494.52, 1.50),
    PaperRow("SCARED 6", None, 1, "EndoGaussian", "enhanced", 0.4779, 689.06, 395.32, 1.78),
)
TABLE_3: Final = (
    ("SCARED 1", "Original", 1146.22, 683.07, 1.68),
    ("SCARED 1", "Tao", 786.95, 1169.02, 0.67),
    ("SCARED 1", "Wang", 1756.08, 1216.13, 1.44),
    ("SCARED 1", "Ours", 924.83, 533.83, 1.73),
    ("SCARED 2", "Original", 1037.03, 970.60, 1.08),
    ("SCARED 2", "Tao", 1138.25, 1198.96, 0.94),
    ("SCARED 2", "Wang", 1436.33, 1476.24, 0.98),
    ("SCARED 2", "Ours", 1304.15, 1105.43, 1.19),
    ("SCARED 3", "Original", 1104.26, 667.84, 1.67),
    ("SCARED 3", "Tao", 783.52, 1264.58, 0.62),
    ("SCARED 3", "Wang", 1588.03, 1215.56, 1.31),
    ("SCARED 3", "Ours", 1363.91, 737.45, 1.87),
    ("SCARED 6", "Original", 920.54, 596.05, 1.54),
    ("SCARED 6", "Tao", 689.95, 778.27, 0.89),
    ("SCARED 6", "Wang", 1594.82, 1200.25, 1.33),
    ("SCARED 6", "Ours", 893.30, 549.15, 1.66),
)
"""Images of SCARED, enhanced: data set, method as in the paper ("Ours" is its own), DV, BV and DV/BV."""
