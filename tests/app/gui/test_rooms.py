"""Who may change what in the window, read from its source."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

GUI = Path(__file__).parents[3] / "app" / "gui"
OWN_MEMORY = {"RunFinder", "Selector"}
"""In work/, what a worker remembers from one request to the next; the state never sees it."""
MEASURED = {"chosen_viewport.py"}
"""In drawing/, what only a graphics context can tell: which of two ways draws faster."""


def sources(room: str) -> list[Path]:
    found = sorted((GUI / room).glob("*.py"))
    assert len(found) > 1
    return found


def changed(tree: ast.AST) -> Iterator[ast.Attribute | ast.Subscript]:
    """Every attribute and item that some statement gives another value or removes."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
            yield node


def root(node: ast.expr) -> str:
    """The first names of a.b.c, up to the state."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        if isinstance(node, ast.Attribute) and node.attr in ("state", "_state"):
            return "state"
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


@pytest.mark.parametrize("path", sources("panels"), ids=lambda path: path.name)
def test_a_panel_calls_actions_and_changes_nothing_itself(path: Path) -> None:
    assert [f"line {node.lineno}: {ast.unparse(node)}" for node in changed(ast.parse(path.read_text()))] == []


@pytest.mark.parametrize("room", ["commands", "drawing", "frame"])
def test_only_actions_and_updates_change_the_state(room: str) -> None:
    found = [
        f"{path.name}:{node.lineno}: {ast.unparse(node)}"
        for path in sources(room)
        if path.name not in MEASURED
        for node in changed(ast.parse(path.read_text()))
        if root(node.value) == "state"
    ]
    assert found == []


def test_the_rule_would_see_a_panel_that_writes() -> None:
    written = "state.a.b = 1\nself._state.a, c = 1, 2\nstate.a[0] += 1\nwith x as state.a: pass\nd = state.a"
    assert [root(node.value) for node in changed(ast.parse(written))] == ["state"] * 4


def test_requests_and_answers_are_values() -> None:
    found = [
        node.name
        for path in sources("work")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef)
        and any(
            "dataclass" in ast.unparse(one) and "frozen=True" not in ast.unparse(one)
            for one in node.decorator_list
        )
    ]
    assert set(found) == OWN_MEMORY
