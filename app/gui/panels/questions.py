"""What is asked before something is lost, but for the closing of the window."""

from __future__ import annotations

from app.gui.panels.editing import draw_question
from app.gui.panels.masking import draw_masking_question
from app.gui.panels.run_questions import draw_run_question
from app.gui.state.app_state import AppState


def draw_questions(state: AppState) -> None:
    """Over everything, while they stand."""
    draw_question(state)
    draw_run_question(state)
    draw_masking_question(state)
