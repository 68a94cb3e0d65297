"""2D vascular enhancement of endoscopic images: section 3.1 of the paper."""

from enhance.image import ImageError
from enhance.params import EnhanceParams
from enhance.pipeline import enhance, measure
from enhance.result import EnhanceResult
from enhance.statistics import Statistics

__all__ = ["EnhanceParams", "EnhanceResult", "ImageError", "Statistics", "enhance", "measure"]
