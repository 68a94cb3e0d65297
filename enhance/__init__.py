"""2D vascular enhancement of endoscopic images: section 3.1 of the paper, other methods, and measures.

Images are (H, W) grey, (H, W, 3) RGB or (H, W, 4) RGBA; uint8, uint16 or float in [0, 1], of either byte
order; results are of the machine's own. Masked arrays are refused. Masks are (H, W), True where
tissue is kept. Visibility only: nothing here detects or diagnoses.

- The paper's method: `enhance`, `EnhanceParams`, `EnhanceResult`, `Omission`; `Enhancer` for many images
  or many settings of one; `measure`, `Pool`, `Statistics` for a clip, `LiveStatistics` for a stream. What
  the endoscope sees inside a dark surround: `find_field`, `FieldOfView`.
- VesselSplat's preset `vessel`: `enhance_vessels`, `VesselParams`, `VesselEnhancer`.
- Others to compare with: `clahe`, `unsharp`, `msrcr`, `aindane`, `aindane_green`, `wang2020`, `jiang2019`,
  and all of them by name in `BASELINES`.
- Measures: `dvbv_otsu`, `dvbv_local`, `DvBv`, `vessel_contrast`, `vessel_cnr`, `vessel_color_difference`,
  `noise_gain`, `chroma_noise_gain`, `highlight_halo`, `edge_halo`, `blackened_share`, `saturated_share`,
  `flicker`; where vessels are: `vesselness`, `vessel_mask`, `field_of_view`; in images below 640 pixels by
  lengths times `line_scale`.

Every mistake in an image is an `ImageError`, every one in a parameter a `pydantic.ValidationError`; both are
ValueErrors. Parameters or statistics of another class are a TypeError. Importing the package loads nothing;
each name loads what it needs when it is first used. Nothing of the process is changed. The kernels compute
on several cores by OpenMP, whose threads spin while they wait: where other work shares the cores, set
OMP_WAIT_POLICY=PASSIVE in the environment before the first is used.
A process that is forked once they have run ends at the next one: take multiprocessing.get_context("spawn").
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from enhance.baselines import (
        BASELINES,
        aindane,
        aindane_green,
        clahe,
        jiang2019,
        msrcr,
        unsharp,
        wang2020,
    )
    from enhance.color_difference import vessel_color_difference
    from enhance.enhancer import Enhancer
    from enhance.field import FieldOfView
    from enhance.field_search import find_field
    from enhance.halos import edge_halo, highlight_halo
    from enhance.image import ImageError
    from enhance.metrics import (
        DvBv,
        blackened_share,
        dvbv_local,
        dvbv_otsu,
        flicker,
        line_scale,
        saturated_share,
        vessel_cnr,
        vessel_contrast,
    )
    from enhance.noise import chroma_noise_gain, noise_gain
    from enhance.params import EnhanceParams
    from enhance.pipeline import Pool, enhance, measure
    from enhance.result import EnhanceResult, Omission
    from enhance.ridges import field_of_view, vessel_mask, vesselness
    from enhance.statistics import LiveStatistics, Statistics
    from enhance.vessel import VesselEnhancer, VesselParams, enhance_vessels

__all__ = [
    "BASELINES",
    "DvBv",
    "EnhanceParams",
    "EnhanceResult",
    "Enhancer",
    "FieldOfView",
    "ImageError",
    "LiveStatistics",
    "Omission",
    "Pool",
    "Statistics",
    "VesselEnhancer",
    "VesselParams",
    "aindane",
    "aindane_green",
    "blackened_share",
    "chroma_noise_gain",
    "clahe",
    "dvbv_local",
    "dvbv_otsu",
    "edge_halo",
    "enhance",
    "enhance_vessels",
    "field_of_view",
    "find_field",
    "flicker",
    "highlight_halo",
    "jiang2019",
    "line_scale",
    "measure",
    "msrcr",
    "noise_gain",
    "saturated_share",
    "unsharp",
    "vessel_cnr",
    "vessel_color_difference",
    "vessel_contrast",
    "vessel_mask",
    "vesselness",
    "wang2020",
]

_MODULES = {
    "baselines": "BASELINES aindane aindane_green clahe jiang2019 msrcr unsharp wang2020",
    "color_difference": "vessel_color_difference",
    "enhancer": "Enhancer",
    "field": "FieldOfView",
    "field_search": "find_field",
    "halos": "edge_halo highlight_halo",
    "image": "ImageError",
    "metrics": "DvBv blackened_share dvbv_local dvbv_otsu flicker line_scale saturated_share vessel_cnr "
    "vessel_contrast",
    "noise": "chroma_noise_gain noise_gain",
    "params": "EnhanceParams",
    "pipeline": "Pool enhance measure",
    "result": "EnhanceResult Omission",
    "ridges": "field_of_view vessel_mask vesselness",
    "statistics": "LiveStatistics Statistics",
    "vessel": "VesselEnhancer VesselParams enhance_vessels",
}
_HOME = {name: f"enhance.{module}" for module, names in _MODULES.items() for name in names.split()}


def __getattr__(name: str) -> _typing.Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(_importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
