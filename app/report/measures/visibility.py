"""Vessel contrast against noise, of every method and amount, and their halos."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

from app.report.bench import Bench, Clock
from app.report.diagrams import Gain, GainDiagram
from app.report.section import Cell, Column, Section, Table
from app.report.visibility import of_clip, of_phantom
from app.report.visibility_front import (
    SHARES,
    STRENGTHS,
    Seen,
    Setting,
    above_vessel,
    averaged,
    best_other,
    has_vessels,
    is_ahead,
    seen,
)
from renderer.listing import count

FRAMES: Final = 3
TITLE: Final = "Vessels: contrast against noise"
COLUMNS: Final = (
    *(Column("method"), Column("setting"), Column("noise gain", ".2f"), Column("contrast gain", ".2f")),
    *(Column("of thin vessels", ".2f"), Column("CNR gain", ".2f"), Column("colour difference gain", ".2f")),
    *(Column("AUC", ".3f"), Column("halo at highlights", ".1f"), Column("halo at edges", ".1f")),
    *(Column("best other with no more noise"), Column("its contrast gain", ".2f")),
)


def measure(bench: Bench, clock: Clock) -> Section:
    """On frames of the clip, evenly spread; of the phantom, whose vessels are known."""
    missing: list[str] = []
    looked_at = list(_images(bench, clock, missing))
    images = [one for one in looked_at if has_vessels(one)]
    found = averaged(images)
    diagram = diagram_of(found, f"{TITLE}, {bench.clip.name}")
    if looked_at and not images:
        missing.append("contrast: no vessels were found")
    elif len(images) < len(looked_at):
        left_out = len(looked_at) - len(images)
        missing.append(f"{left_out} of {count(len(looked_at), 'image')}: no vessels were found, or no noise")
    return Section(
        title=TITLE,
        sentences=(*_method(bench, len(images)), *_reading(found)) if diagram.gains else (),
        gain_diagrams=(diagram,) if diagram.gains else (),
        tables=(table(found),) if diagram.gains else (),
        not_measured=tuple(missing),
    )


def diagram_of(found: Seen, title: str) -> GainDiagram:
    """A series for each method; without what has no contrast."""
    return GainDiagram(
        title=title,
        gains=tuple(
            Gain(
                series=setting.method,
                setting=setting.amount,
                noise=one.noise,
                contrast=one.contrast,
                is_default=setting.is_default,
            )
            for setting, one in found.items()
            if one.noise > 0 and one.contrast > 0
        ),
    )


def table(found: Seen) -> Table:
    """A row for each setting."""
    return Table(
        title="Every method and amount",
        columns=COLUMNS,
        rows=tuple(_row(setting, found) for setting in found),
        note="Gains are relative to the original: 1 is no change. A dash: vessels are brighter than what is "
        "around them. Thin vessels are up to 3 pixels wide; where there are few, all count. CNR: contrast to "
        "noise ratio; its noise includes texture. AUC: area under the ROC curve of the darkness of green "
        "against its surroundings, as a classifier of these vessels; 0.5 is chance. Halos are in grey "
        "levels, apart from vessels; a dash: no highlight, or no strong edge.",
    )


def _images(bench: Bench, clock: Clock, missing: list[str]) -> Iterator[Seen]:
    samples = of_phantom(FRAMES) if bench.given is None else of_clip(bench.given, FRAMES)
    for number, one in enumerate(samples, 1):
        if clock.is_out:
            missing.append(f"image {number}: no time left")
            continue
        bench.say(f"contrast of vessels against noise, image {number}")
        yield seen(one)


def _row(setting: Setting, found: Seen) -> tuple[Cell, ...]:
    one, other = found[setting], best_other(setting, found)
    return (
        *(setting.method, setting.amount, one.noise, one.contrast, one.thin, one.cnr, one.color, one.auc),
        *(one.highlight_halo, one.edge_halo),
        *(("none", None) if other is None else (f"{other.method} {other.amount}", found[other].contrast)),
    )


def _method(bench: Bench, count: int) -> Iterator[str]:
    vessels = (
        "The vessels of the phantom are known."
        if bench.given is None
        else "As vessels count the strongest dark ridges of each original, whether or not they are vessels; "
        "they are the same for all methods."
    )
    yield (
        "Weber contrast of vessels in green, and noise of flat tissue without clipped pixels, both relative "
        f"to the original: vessel at {len(STRENGTHS)} strengths, as it is, with contrast 1 and shadows 0, "
        "and with brightness and colour kept but for the vessels; every other method blended with the "
        f"original in {len(SHARES)} shares, so that methods can be compared at the same noise. Geometric "
        f"means over {count} {'image' if count == 1 else 'images'}. {vessels}"
    )
    yield (
        "A halo is how much darker an image is at 2 to 10 pixels from a specular highlight than at 10 to 20, "
        "where the original has the same grey level; at strong edges, how much darker on their dark side and "
        "brighter on their bright side. Neither is a matter of contrast: a tone curve has no halo."
    )


def _reading(found: Seen) -> Iterator[str]:
    """What the figures say, in sentences."""
    own = [setting for setting in found if setting.is_vessel]
    default = next(setting for setting in own if setting.is_default)
    one, other = found[default], best_other(default, found)
    rival = (
        "No other has so little noise."
        if other is None
        else f"The best of the others with no more noise is {other.method}, {other.amount}, with "
        f"{found[other].contrast:.2f} times."
    )
    ahead = sum(is_ahead(setting, found) for setting in own)
    yield (
        f"The method vessel, by default, has {one.contrast:.2f} times the contrast at {one.noise:.2f} times "
        f"the noise. {rival} At {ahead} of its {len(own)} settings, no other method has more contrast with "
        "no more noise."
    )
    if above := above_vessel(found):
        each = (
            f"{setting.method}, {setting.amount} ({one.contrast:.2f} at {one.noise:.2f})"
            for setting, one in ((setting, found[setting]) for setting in above)
        )
        yield (
            "More contrast than vessel has at any setting with no more noise (contrast at noise, relative "
            f"to the original): {'; '.join(each)}."
        )
    yield from _reading_of_halos(found, "highlights", lambda setting: found[setting].highlight_halo)
    yield from _reading_of_halos(found, "strong edges", lambda setting: found[setting].edge_halo)


def _reading_of_halos(found: Seen, where: str, halo: Callable[[Setting], float]) -> Iterator[str]:
    halos = {setting.method: halo(setting) for setting in found if setting.is_default}
    if all(map(math.isfinite, halos.values())):
        ranks = sorted(halos, key=lambda method: halos[method])
        yield f"Halos at {where}, grey levels: {', '.join(f'{one} {halos[one]:.1f}' for one in ranks)}."
