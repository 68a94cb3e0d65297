"""The example of each exported name runs, as it stands, and gives what it says."""

from __future__ import annotations

from doctest import ELLIPSIS, DocTest, DocTestFinder, DocTestRunner
from types import ModuleType
from typing import Any

import pytest

import enhance
import renderer

FACES = (enhance, renderer)
VALUES = ("BASELINES", "TrainEvent")
"""Neither functions nor classes: their text stands below them."""
NEEDS_OPENGL = ("SplatView", "render_offscreen", "standalone_context")


def examples() -> list[Any]:
    return [
        pytest.param(
            face, name, id=f"{face.__name__}.{name}", marks=[pytest.mark.gl] * (name in NEEDS_OPENGL)
        )
        for face in FACES
        for name in face.__all__
        if name not in VALUES
    ]


@pytest.mark.parametrize(("face", "name"), examples())
def test_the_example_of(face: ModuleType, name: str, request: pytest.FixtureRequest) -> None:
    if name in NEEDS_OPENGL:
        request.getfixturevalue("ctx")
    [example] = DocTestFinder(recurse=False).find(getattr(face, name), name, module=False, globs={})
    assert example.examples, "there is none"
    assert failures_of(example) == ""


def failures_of(example: DocTest) -> str:
    said: list[str] = []
    DocTestRunner(optionflags=ELLIPSIS).run(example, out=said.append)
    return "".join(said)
