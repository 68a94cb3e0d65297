"""Commands for each kind of export: they open the panel on it, where name and folder are."""

from __future__ import annotations

from functools import partial

from app.gui.actions import export_actions
from app.gui.actions.export_offers import GROUPS, OFFERS
from app.gui.commands.command import Command, Needs
from app.gui.state.exports import What


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
    synonyms = ("splats",) if "splats" in what else ()
    return Command(f"{title}: {offer.within}…", act, text=text, applies=applies, synonyms=synonyms)
