"""The manual's tree is that of the folders, and README and manual link to what is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MANUAL = ROOT / "assets" / "manual"
CODE = (MANUAL / "code.md").read_text(encoding="utf-8")
TREE = CODE.split("```")[1]
NAMES = re.compile(r"( *)((?:[\w*]+(?:/|\.py) {0,2})+)")
"""The names that a line begins with, behind two spaces for each folder that they lie in."""
DEEPEST = 6
"""Spaces; what stands farther to the right goes on with the line above."""
TOPS = ("app", "renderer", "enhance")


def listed() -> list[str]:
    """All names at the beginning of a line, as paths from the root."""
    folders: list[str] = []
    found = []
    for line in TREE.splitlines():
        named = NAMES.match(line)
        if named is None or len(named[1]) > DEEPEST:
            continue
        folders = folders[: len(named[1]) // 2]
        names = named[2].split()
        found += ["".join([*folders, name]) for name in names]
        folders.append(names[0])
    return found


def test_what_is_to_be_installed_is_one_of_the_packages_alone() -> None:
    """Not `vesselsplat[...]`: with it pip also installs torch where that was left out (`make TORCH=no`)."""
    files = [
        path for top in ("app", "renderer", "assets/manual") for path in (ROOT / top).rglob("*.[pm][yd]")
    ]
    said = "\n".join(path.read_text(encoding="utf-8") for path in files)
    named = re.findall(r"pip install (?:-U )?((?:[a-z][\w-]*(?: |\b))+)", said)
    asked = {name for names in named for name in names.split()}
    pinned = {line.split("==")[0] for line in (ROOT / "constraints.txt").read_text().splitlines()}
    assert {"dask", "pydicom", "usd-core"} <= asked <= pinned
    assert "vesselsplat[" not in said


@pytest.mark.parametrize("path", listed())
def test_what_the_tree_names_is_there(path: str) -> None:
    found = list(ROOT.glob(path.rstrip("/")))
    assert found
    assert all(each.is_dir() == path.endswith("/") for each in found)


@pytest.mark.parametrize("top", TOPS)
def test_files_that_are_mentioned_lie_in_the_folder_of_that_section(top: str) -> None:
    section = TREE[TREE.index(f"\n{top}/") :].split("\n\n")[0]
    there = {path.name for path in (ROOT / top).rglob("*.py")}
    mentioned = re.findall(r"\b\w+\.py\b", section)
    assert mentioned
    assert set(mentioned) <= there


@pytest.mark.parametrize("top", TOPS)
def test_every_folder_and_file_of_the_first_level_is_in_the_tree(top: str) -> None:
    inside = [path for path in (ROOT / top).iterdir() if path.name[0] not in "._"]
    names = [f"{path.name}/" for path in inside if path.is_dir()]
    names += [path.name for path in inside if path.suffix == ".py"]
    section = TREE[TREE.index(f"\n{top}/") :].split("\n\n")[0]
    assert [name for name in names if not re.search(rf"(?<![\w/]){re.escape(name)}", section)] == []


def test_the_files_of_the_walk_are_there() -> None:
    walk = CODE.split("From a slider to a kernel")[1].split("## Conventions")[0]
    files = re.findall(r"`([\w/]+\.py)`", walk)
    assert len(files) > 10
    everywhere = [path.as_posix() for path in ROOT.glob("*/**/*.py")]
    assert [name for name in files if not any(path.endswith(f"/{name}") for path in everywhere)] == []


@pytest.mark.parametrize("page", [ROOT / "README.md", *MANUAL.glob("*.md")], ids=lambda page: page.name)
def test_links_lead_to_what_is_there(page: Path) -> None:
    links = re.findall(r"\]\((?!https://)([^)]+)\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


def test_readme_leads_to_every_page_of_the_manual() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [page.name for page in MANUAL.glob("*.md") if f"assets/manual/{page.name}" not in readme] == []
