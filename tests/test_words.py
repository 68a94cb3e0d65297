"""The texts a user reads are in the plain words of the field: phrases that have been put better stay out."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("app", "renderer", "enhance")
PAGES = (
    "README.md",
    "CHANGELOG.md",
    *(f"assets/manual/{page.name}" for page in (ROOT / "assets/manual").glob("*.md")),
)
SAY_INSTEAD = (
    ("says of itself", "has (invalid) provenance"),
    ("it waits on", "it stays in the queue"),
    ("in passing", "autosaved"),
    ("beaten by no other", "Pareto-optimal"),
    ("does without", "leaves out, does not need"),
    ("stands still", "is fixed; is paused"),
    ("starts no other one", "the queue waits"),
    ("until you say so", "press Start to run them"),
    ("full stop", "period"),
    ("the present setting", "the current settings"),
    ("the last setting back", "undo the last change"),
    ("for one of the screen", "actual pixels (1:1)"),
    ("what was whole", "finished files are kept"),
    ("what is whole", "finished files are kept"),
    ("surface is there", "no surface under the pointer"),
    ("by the processor", "on the CPU"),
    ("the processor", "the CPU"),
    ("a file that is none", "a file that is not an image"),
    ("the own", "VesselSplat's"),
    ("the hand rests", "when you pause"),
    ("without anyone's doing", "say what changes it"),
    ("made again", "reproduced"),
    ("being made", "in training"),
    ("make them again", "reproduce them"),
    ("makes it again", "reproduces it"),
    ("taken for", "treated as, read as"),
    ("as at first", "the default"),
    ("goes on from", "resumes from"),
    ("gone on from", "resumed from"),
    ("what waits", "the queue"),
    ("cut short", "interrupted"),
    ("look at it", "view model"),
    ("as asked", "as requested"),
    ("at hand", "available"),
    ("on its way", "waiting for"),
    ("is said", "name who says it, or use a notice"),
    ("is told", "is shown, is reported"),
    ("put right", "repaired"),
    ("the time was used up", "no time left"),
    ("every knob", "every parameter"),
    ("photo", "frame, of a clip; image, of a file"),
    ("picture", "image; frame, of a clip"),
    ("numbers a Gaussian", "numbers per Gaussian"),
    ("file of splats", "splat file"),
)
CONTRACT = ("enhanced picture",)
"""Kinds of exports that files hold."""
EXPORTS = ("moving splats", "splats of this moment", "splats of all frames", "splats through time")
"""Kinds that the window offers, by names that it does not show."""
KEYS = ("input_photo", "original_photo", "photos")
"""Of `evaluate --json` and of a report's rows."""


def texts() -> Iterator[tuple[str, str]]:
    """Where a text stands, and the text: string literals of more than one word, and the pages."""
    for page in PAGES:
        for number, line in enumerate((ROOT / page).read_text(encoding="utf-8").splitlines(), 1):
            yield f"{page}:{number}", line
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for number, text in literals(path.read_text(encoding="utf-8")):
                yield f"{path.relative_to(ROOT)}:{number}", text


def literals(source: str) -> Iterator[tuple[int, str]]:
    """Without docstrings but for those of fields, which are help and tooltips."""
    tree = ast.parse(source)
    own = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    shown = "use_attribute_docstrings" in source
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and not shown:
            own.add(id(node.value))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in own:
            yield node.lineno, node.value


def old_phrases(text: str) -> list[str]:
    words = " ".join(text.split())
    if " " not in words or words in CONTRACT:
        return []
    return [
        f"{old!r}, say: {new}"
        for old, new in SAY_INSTEAD
        if re.search(rf"(?<![\w./]){re.escape(old)}(?!\w*[._(]\w)", words, re.IGNORECASE)
    ]


def test_texts_are_in_the_words_of_the_field() -> None:
    found = [f"{place}: {said}" for place, text in texts() for said in old_phrases(text)]
    assert not found, "\n".join(found)


NAMES = ("app/enhancement/setting_words.py", "renderer/measuring/raster_accuracy.py")
"""What is drawn into images, which are replayed with the same; and names of a report's rows."""


def test_shares_are_said_with_a_space_before_the_sign() -> None:
    """Side by side in one panel or one command, 19% and 36 % look like two programs'."""
    found = [
        str(path.relative_to(ROOT))
        for package in ("app/commands", "app/enhancement", "app/gui", "app/runs", "app/scenes", "renderer")
        for path in sorted((ROOT / package).rglob("*.py"))
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.search(r'f".*\{[^{}]*:\.\d%\}', line)
    ]
    assert set(found) == {*NAMES}, "with a space"


@pytest.mark.parametrize("old", [old for old, _ in SAY_INSTEAD])
def test_each_old_phrase_is_noticed(old: str) -> None:
    [number, text] = next(literals(f'"""A module."""\nsay(f"a {old} {{name}}, b")\n'))
    assert number == 2
    assert any(old in said for said in old_phrases(text))


def test_names_and_docstrings_say_frame_or_image() -> None:
    """As texts do: one word for one thing."""
    found = [
        f"{path.relative_to(ROOT)}: {word}"
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
        for word in re.findall(r"\w*photo(?!metric)\w*", path.read_text(encoding="utf-8"), re.IGNORECASE)
        if word not in KEYS
    ]
    assert not found, "\n".join(found)


def test_a_model_has_gaussians_and_lies_in_a_splat_file() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{number}: {text}"
        for path in sorted((ROOT / "app/gui").rglob("*.py"))
        for number, text in literals(path.read_text(encoding="utf-8"))
        if re.search(r"(?i)\bsplats\b", text) and " " in text and text not in EXPORTS
    ]
    assert not found, "\n".join(found)


def test_a_kind_that_files_hold_is_left_alone() -> None:
    assert not old_phrases("enhanced picture")
    assert old_phrases("an enhanced picture")
