"""Provenance: what goes into a PNG comes out again, and the pixels are untouched."""

from __future__ import annotations

import getpass
import io
import json
import math
import os
import shutil
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path, PureWindowsPath

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from app.errors import UserError
from app.files import provenance as module
from app.files.provenance import (
    NOTICE,
    digest,
    encode_png,
    provenance,
    read_provenance,
    strict_json,
    version,
    write_png,
)
from app.files.records import Source
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip

TEXTS = st.dictionaries(st.text(max_size=20), st.text(max_size=50) | st.integers() | st.none(), max_size=5)


def test_a_program_that_is_not_installed_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> str:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(module, "installed_version", absent)
    with pytest.raises(UserError, match="expected VesselSplat to be installed"):
        provenance()


def test_a_checkout_says_its_own_version_whatever_its_install_noted(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(module, "installed_version", lambda name: "0.1.0")
    project = tomllib.loads((Path(module.__file__).parents[2] / "pyproject.toml").read_text())["project"]
    assert version() == project["version"]
    texts = {
        "installed": None,
        "another": '[project]\nname = "other"\nversion = "9"\n',
        "damaged": "[project",
        "without": "[tool.ruff]\n",
    }
    for name, text in texts.items():
        path = tmp_path / f"{name}.toml"
        if text is not None:
            path.write_text(text)
        monkeypatch.setattr(module, "SOURCE", path)
        module._source_version.cache_clear()
        assert version() == "0.1.0"
    module._source_version.cache_clear()


@given(facts=TEXTS)
def test_any_facts_survive_and_pillow_reads_them_too(facts: dict[str, object]) -> None:
    content = encode_png(np.zeros((2, 3, 3), dtype=np.uint8), facts, b"")
    with Image.open(io.BytesIO(content)) as picture:
        assert json.loads(picture.info["vesselsplat"]) == facts
        assert picture.info["srgb"] == 0


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 3), (5, 7, 4)])
def test_pixels_and_facts_round_trip(tmp_path: Path, dtype: type, shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(3)
    image = rng.integers(0, np.iinfo(dtype).max, shape, dtype=dtype, endpoint=True)
    path = tmp_path / "picture.png"
    write_png(path, image, provenance(frame=7, values=np.arange(3)))
    stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    order = [2, 1, 0, 3]
    assert np.array_equal(stored if stored.ndim == 2 else stored[..., order[: stored.shape[2]]], image)
    facts = read_provenance(path)
    assert (facts["frame"], facts["values"], facts["notice"]) == (7, [0, 1, 2], NOTICE)
    assert list(tmp_path.iterdir()) == [path]


def test_a_picture_without_provenance_says_so(tmp_path: Path) -> None:
    path = tmp_path / "plain.png"
    Image.new("RGB", (3, 3)).save(path)
    with pytest.raises(UserError, match=r"no provenance in plain\.png"):
        read_provenance(path)
    (tmp_path / "text.png").write_text("none")
    with pytest.raises(UserError):
        read_provenance(tmp_path / "text.png")


def test_strict_json_has_no_nan() -> None:
    values = {"a": math.nan, "b": np.float32(math.inf), "c": np.array([1.0, math.nan]), "d": (1, np.int64(2))}
    assert json.loads(strict_json(values)) == {"a": None, "b": None, "c": [1.0, None], "d": [1, 2]}
    with pytest.raises(TypeError, match="no JSON form for object"):
        strict_json({"a": object()})


def test_strict_json_replaces_what_is_not_utf8() -> None:
    name = os.fsdecode(b"caf\xe9")
    assert json.loads(strict_json({"name": name, "deep": [(name, "é")]})) == {
        "name": "caf?",
        "deep": [["caf?", "é"]],
    }


def test_the_digest_of_a_folder_follows_content_and_names_alone(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for folder, names in ((first, ("a", "b")), (second, ("b", "a"))):
        folder.mkdir()
        for name in names:
            (folder / f"{name}.png").write_text(name)
    assert digest(first) == digest(second)
    (first / "a.png").rename(first / "c.png")
    assert digest(first) != digest(second)
    (first / "c.png").rename(first / "a.png")
    (first / "a.png").write_text("changed")
    assert digest(first) != digest(second)


def test_the_digest_of_a_clip_is_of_what_is_read(clip_path: Path, tmp_path: Path) -> None:
    clip = tmp_path / "clip"
    shutil.copytree(clip_path, clip)
    before = digest(clip)
    assert before == digest(clip_path)
    for name in ("Thumbs.db", "notes.txt", "images/Thumbs.db", "run/run.json", "exports/1.png"):
        (clip / name).parent.mkdir(exist_ok=True)
        (clip / name).write_text("not of the clip")
    (clip / "nowhere.png").symlink_to(clip / "nothing")
    (clip / "images" / "nowhere.png").symlink_to(clip / "nothing")
    (clip / "loop").symlink_to(clip / "loop")
    (clip / "round").symlink_to(clip)
    assert digest(clip) == before
    assert len(open_clip(clip)) == len(open_clip(clip_path))
    for name in ("images/frame-000003.color.png", "masks/frame-000003.mask.png", "poses_bounds.npy"):
        content = (clip / name).read_bytes()
        (clip / name).write_bytes(content + b"1")
        assert digest(clip) != before
        (clip / name).write_bytes(content)
    assert digest(clip) == before


def test_the_digest_of_a_folder_of_pictures_is_of_those_that_are_frames(tmp_path: Path) -> None:
    for name in ("1.png", "2.png", "3.png"):
        (tmp_path / name).write_text(name)
    before = digest(tmp_path)
    (tmp_path / "cover.png").write_text("no frame, it has no number")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "4.png").write_text("below")
    assert digest(tmp_path) == before
    (tmp_path / "4.png").write_text("a frame")
    assert digest(tmp_path) != before


def test_a_source_tells_neither_path_nor_user(tmp_path: Path) -> None:
    path = tmp_path / "clip.bin"
    path.write_bytes(b"frames")
    text = strict_json(provenance(source=Source.of(path)))
    assert str(tmp_path) not in text
    assert f"/{getpass.getuser()}" not in text
    assert '"clip.bin"' in text


@pytest.mark.parametrize("names", [("left", "right"), ("input", "mask"), ("input", "depth")])
def test_the_digest_of_pictures_in_folders_is_of_those(tmp_path: Path, names: tuple[str, str]) -> None:
    for name in names:
        (tmp_path / name).mkdir()
        Image.new("RGB", (3, 3)).save(tmp_path / name / "1.png")
    found = [digest(tmp_path)]
    for name in names:
        Image.new("RGB", (3, 4)).save(tmp_path / name / "1.png")
        found.append(digest(tmp_path))
    assert len(set(found)) == 3
    (tmp_path / "exports").mkdir()
    (tmp_path / "exports" / "notes.txt").write_text("not of the clip")
    assert digest(tmp_path) == found[-1]


def test_the_digest_of_a_scared_folder_is_of_all_that_is_read(tmp_path: Path) -> None:
    folder = tmp_path / "clip"
    write_phantom(folder, PhantomParams(n_frames=2, width=64, height=48), layout="scared")
    before = digest(folder)
    changed = [path for path in sorted((folder / "data").rglob("*")) if path.is_file()]
    assert len({path.parent.name for path in changed}) >= 3
    for path in changed:
        content = path.read_bytes()
        path.write_bytes(content + b" ")
        assert digest(folder) != before, path
        path.write_bytes(content)
    assert digest(folder) == before


def test_every_system_has_the_same_digest_of_names_in_both_cases(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("Right.obj", "left.obj", "a-b/x.obj", "a/B.obj", "a/a.obj"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(name)
    here = digest(tmp_path)
    assert here.startswith("5066e4111a07d637")
    monkeypatch.setattr(module, "PurePath", PureWindowsPath)
    assert digest(tmp_path) == here
