"""Pictures for a report: drawn from the data at full resolution, labelled, with their provenance inside."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.color_bar import with_bar
from app.gui.legible import legible
from app.gui.work.enhancing import Pictures
from app.gui.work.viewing import BACKGROUND, View, ViewRequest, draw_view
from app.methods import PAPER, VESSEL
from app.provenance import NOTICE, provenance, source, write_png
from app.views import Composed, ViewKind
from enhance.vessel import VesselParams
from renderer.clip import ByteImage
from renderer.readers.clip_options import DEFAULTS, ClipOptions

INK, GROUND = (235, 235, 235), (28, 28, 28)


@dataclass(frozen=True, eq=False)
class SaveRequest:
    """What is on screen, to be written into `folder`: the pair of pictures, the 3D view, or both."""

    folder: Path
    pictures: Pictures | None
    view: ViewRequest | None
    clip_options: ClipOptions = DEFAULTS
    """How the clip of the pictures was read."""

    @property
    def stem(self) -> str:
        """What the file is called after: the clip of the pictures, or else the run."""
        if self.pictures is not None:
            return self.pictures.request.clip.path.stem
        return self.view.shown.name if self.view is not None else "vesselsplat"


@dataclass(frozen=True)
class Saved:
    path: Path


@dataclass(frozen=True, eq=False)
class Panel:
    """One picture of the export, with what stands above it."""

    label: str
    image: ByteImage


def save_picture(request: SaveRequest) -> Iterator[Saved]:
    """Write one PNG with all panels side by side. Raises OSError or UserError."""
    panels, facts = _panels(request)
    stamp = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S-%f")[:-3]
    path = request.folder / f"{request.stem}-{stamp}.png"
    write_png(path, sheet(panels), facts)
    yield Saved(path)


def _panels(request: SaveRequest) -> tuple[list[Panel], dict[str, Any]]:
    panels: list[Panel] = []
    facts: dict[str, Any] = {"kind": "screenshot"}
    if (pictures := request.pictures) is not None:
        wanted = pictures.request
        label = wanted.clip.labels[wanted.frame_index]
        facts["source"] = source(wanted.clip.path)
        panels += picture_panels(pictures)
        facts["clip_options"] = request.clip_options
        facts["frame"] = {"index": wanted.frame_index, "label": label}
        if pictures.enhanced is not None:
            facts["method"] = VESSEL if isinstance(wanted.params, VesselParams) else PAPER
            facts |= {"params": wanted.params, "statistics": pictures.statistics}
            facts |= {"scope": wanted.scope, "tissue_only": wanted.tissue_only}
            facts |= {"mask": wanted.mask, "span": wanted.span}
    if request.view is not None:
        view = _drawn(request.view)
        image = with_bar(Composed(view.image, view.scale))
        panels.append(view_panel(view.request.shown.name, image, view.request.kind))
        facts["view"] = view_facts(view.request)
    return panels, provenance(**facts)


def picture_panels(pictures: Pictures) -> list[Panel]:
    """The photo, and what became of it where it is enhanced."""
    label = pictures.request.clip.labels[pictures.request.frame_index]
    photo = Panel(f"Original   {label}", pictures.photo)
    if pictures.enhanced is None:
        return [photo]
    return [photo, Panel("Enhanced   " + describe(pictures), pictures.enhanced)]


def view_panel(name: str, image: ByteImage, kind: ViewKind) -> Panel:
    """A model, by the name of its run or file."""
    shows = "" if kind == "color" else f"   {kind}"
    return Panel(f"Reconstruction   {name}{shows}", image)


def view_facts(request: ViewRequest) -> dict[str, Any]:
    """Its own run and clip, which need not be those of the pictures beside it."""
    shown = request.shown
    origin = shown.origin.facts if shown.origin else {"run": {"name": shown.name}}
    return origin | {
        "iteration": shown.iteration,
        "time": request.time,
        "camera": request.camera.to_json(),
        "near": request.near,
        "background": BACKGROUND,
        "renderer": "numba on the CPU",
        "view": request.kind,
        "frame": shown.frame_at(request.time),
    }


def _drawn(request: ViewRequest) -> View:
    """The view with as many pixels across as the clip's photos have, at least."""
    photo = request.shown.cameras[0]
    scale = max(1.0, photo.width / request.camera.width, photo.height / request.camera.height)
    (view,) = draw_view(request.scaled(scale))
    return view


def describe(pictures: Pictures) -> str:
    """What the enhancement used, in the words of its method."""
    used, params = pictures.statistics, pictures.request.params
    if used is None or params is None:
        return ""
    if isinstance(params, VesselParams):
        return f"{VESSEL} · strength {params.strength:.2f} · lift {params.lift:.2f} · d {params.d_factor:.2f}"
    z = f"z {'auto ' if params.z is None else ''}{used.z:.2f}"
    exponents = "/".join(f"{p:.2f}" for p in dict.fromkeys(used.p))
    p = f"P {'auto ' if params.p is None else ''}{exponents}"
    return f"{z} · {p} · d {params.d_factor:.2f}"


def sheet(panels: list[Panel]) -> ByteImage:
    """(H, W, 3): the panels side by side at their own sizes, a caption above each, the notice below."""
    margin = 8
    size = max(14, max(panel.image.shape[0] for panel in panels) // 32)
    strip = 2 * size
    width = sum(panel.image.shape[1] + margin for panel in panels) - margin
    height = max(panel.image.shape[0] for panel in panels) + 2 * strip
    page = Image.new("RGB", (width, height), GROUND)
    draw, x = ImageDraw.Draw(page), 0
    for panel in panels:
        label = legible(panel.label)
        font = _fitting(label, size, panel.image.shape[1] - size)
        draw.text((x + size // 2, strip // 2), label, INK, font, anchor="lm")
        page.paste(Image.fromarray(panel.image), (x, strip))
        x += panel.image.shape[1] + margin
    small = _fitting(NOTICE, size * 3 // 4, width - size)
    draw.text((size // 2, height - strip // 2), NOTICE, (170, 170, 170), small, anchor="lm")
    return np.asarray(page, dtype=np.uint8)


def _fitting(text: str, size: int, width: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The built-in font, small enough for `text` to fit into `width` pixels."""
    font = ImageFont.load_default(size)
    shrunk = int(size * width / max(font.getlength(text), 1))
    return font if shrunk >= size else ImageFont.load_default(max(6, shrunk))
