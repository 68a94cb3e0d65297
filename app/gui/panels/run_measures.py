"""How close the finished run that is shown comes to frames that it was not trained on, in numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from imgui_bundle import imgui

from app.gui.actions import laid_out
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import cell, explain, in_table, muted, percent
from renderer.listing import count
from renderer.measuring.tissue_seen import SELDOM
from renderer.metrics import OPAQUE

Row = tuple[str, str, Callable[[float], str], str]


def _decibels(value: float) -> str:
    return f"{value:.1f} dB"


def _percent(value: float) -> str:
    """Rounded down: 100 % is all of it."""
    return f"{int(1000 * value) / 10:.1f} %"


ROWS: Final[tuple[Row, ...]] = (
    ("PSNR", "psnr", _decibels, "As in published results: over the pixels that the clip's masks leave, in "
     "many clips only those with measured depth; the others are black in both images."),
    ("PSNR, all tissue", "psnr_tissue", _decibels, "Over all tissue that is seen, with measured depth "
     "or without: everything but instruments, burned-in text and what your mask leaves out."),
    ("PSNR, seldom-seen tissue", "psnr_seldom", _decibels, "Over tissue that at most "
     f"{percent(SELDOM)} of the training frames show, mostly because an instrument hides it. Not measured "
     "where all tissue is seen more often, or where the camera moves."),
    ("Covered tissue", "coverage", _percent, "Share of the tissue that is seen where the model is at "
     f"least {percent(OPAQUE)} opaque. In the rest the background shows through."),
)  # fmt: skip
HELD_OUT: Final = "Frames that the run was not trained on. Higher is better in every line."
SHORT: Final = "The clip is too short to hold frames out, so these are its training frames."


def draw_run_measures(state: AppState) -> None:
    """Asks for them while it is on screen; nothing where they cannot be had."""
    laid_out.see_run_measures(state)
    request, found = state.run_measures_request, state.runs.measures
    if request is None:
        return
    if found is None or found.request != request or not found.is_whole:
        ours = found if found is not None and found.request == request else None
        done = f": {len(ours.frames)} of {ours.count}" if ours is not None and ours.frames else "…"
        muted(f"Measuring the held-out frames{done}")
        # As high as it will be: what is below stays where it is.
        _draw_rows(lambda name, said: "…")
        return
    if found.count == 0:
        muted("Not measured: see the log.")
        return
    kind = "held-out" if found.are_held_out else "training"
    muted(f"Mean of {count(found.count, f'{kind} frame')}")
    explain(HELD_OUT if found.are_held_out else SHORT)
    if not state.editing.edits.is_empty:
        muted("Of the model as trained, without the edits.")

    def value(name: str, said: Callable[[float], str]) -> str:
        mean = found.mean(name)
        return "—" if mean is None else said(mean)

    _draw_rows(value)


def _draw_rows(value: Callable[[str, Callable[[float], str]], str]) -> None:
    for label, name, said, text in in_table("run measures", (None, 0.0), ROWS, imgui.TableFlags_.row_bg):
        cell(label, tooltip=text)
        cell(value(name, said), theme.now().text, text)
