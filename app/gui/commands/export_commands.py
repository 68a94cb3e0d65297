"""Commands for each kind of export: they open the panel on it, where name and folder are."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Final

from app.gui.actions import export_actions
from app.gui.actions.export_offers import GROUPS, OFFERS, Form, Offer
from app.gui.commands.command import Command, Needs
from app.gui.state.exports import What

SURFACE: Final = ("mesh", "stl", "polygons", "blender", "print")
VIDEO: Final = ("film", "movie", "mp4", "gif", "animation")
SYNONYMS: Final[Mapping[Form, tuple[str, ...]]] = {
    "picture": ("picture", "screenshot", "snapshot", "save"),
    "panes video": VIDEO,
    "view video": VIDEO,
    "measures": ("excel", "spreadsheet", "statistics", "quantify", "histogram", "numbers", "results"),
    "splats": ("splats", "point", "cloud"),
    "splat folder": ("splats", "point", "cloud"),
    "moving splats": ("splats", "blender", "unreal", "unity", "animation"),
    "browser model": ("web", "website", "share"),
    "surface mesh": SURFACE,
    "surface folder": SURFACE,
    "model arrays": ("numpy", "python", "matlab"),
    "tracks": ("motion", "trajectory", "excel"),
    "cameras": ("poses", "trajectory"),
}
RENDERED: Final = ("render", "rendering")


def exporting() -> tuple[Command, ...]:
    """In the order of the panel."""
    return tuple(
        _command(title, what)
        for title in GROUPS
        for what, offer in OFFERS.items()
        if offer.traits.group == title
    )


def _command(title: str, what: What) -> Command:
    offer = OFFERS[what]

    applies = Needs(partial(export_actions.why_not_export, what=what))
    act = partial(export_actions.choose_what, what=what)
    text = f"export {title if title[1].isupper() else title.lower()}: {offer.text}"
    return Command(f"{title}: {offer.within}…", act, text=text, applies=applies, synonyms=_synonyms(offer))


def _synonyms(offer: Offer) -> tuple[str, ...]:
    rendered = RENDERED if offer.sees != "no" and not offer.sides and not offer.is_of_model else ()
    return *SYNONYMS.get(offer.form, ()), *rendered
