"""The commands of the View menu: panels and how the window looks."""

from __future__ import annotations

from app.gui.command import Command, Outside, Section, start


def view_sections(outside: Outside) -> tuple[Section, ...]:
    panels = tuple(
        Command(
            name,
            lambda s, name=name: outside.toggle_panel(name),  # type: ignore[misc]
            text=text,
            ticked=lambda s, name=name: outside.panel_shown(name),  # type: ignore[misc]
        )
        for name, text in (
            ("Log", "panel: what happened in this session"),
            ("Notes", "panel: notes that are saved with the session"),
            ("Report", "panel: a report of measurements that was opened"),
        )
    )
    layout = Command(
        "Standard layout", start(outside.layout), text="all panels back where they were at first"
    )
    return Section("View", panels), Section("View", (layout,))
