"""2D vascular enhancement of endoscopic images: section 3.1 of the paper."""

import os

from enhance.enhancer import Enhancer
from enhance.image import ImageError
from enhance.params import EnhanceParams
from enhance.pipeline import enhance, measure
from enhance.result import EnhanceResult
from enhance.statistics import LiveStatistics, Statistics

# numba's threads must not spin while they wait for each other: see renderer/__init__.py. The runtime reads
# this once, when numba first starts its threads.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

__all__ = [
    "EnhanceParams",
    "EnhanceResult",
    "Enhancer",
    "ImageError",
    "LiveStatistics",
    "Statistics",
    "enhance",
    "measure",
]
