"""Provenance: what goes into a PNG comes out again, and the pixels are untouched."""

from __future__ import annotations

import getpass
import io
import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from pydantic_core import PydanticSerializationError

from app.errors import UserError
from app.provenance import (
    NOTICE,
    digest,
    encode_png,
    provenance,
    read_provenance,
    source,
    strict_json,
    write_png,
)

TEXTS = st.dictionaries(st.text(max_size=20), st.text(max_size=50) | st.integers() | st.none(), max_size=5)


@given(facts=TEXTS)
def test_any_facts_survive_and_pillow_reads_them_too(facts: dict[str, object]) -> None:
    content = encode_png(np.zeros((2, 3, 3), dtype=np.uint8), facts)
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
    with pytest.raises(PydanticSerializationError, match="no JSON form for object"):
        strict_json({"a": object()})


def test_the_digest_of_a_folder_follows_content_and_names_alone(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for folder, names in ((first, ("a", "b")), (second, ("b", "a"))):
        (folder / "sub").mkdir(parents=True)
        for name in names:
            (folder / "sub" / name).write_text(name)
    assert digest(first) == digest(second)
    (first / ".hidden").write_text("left by a file manager")
    (first / "run").mkdir()
    (first / "run" / "run.json").write_text("{}")
    assert digest(first) == digest(second)
    (first / "sub" / "a").rename(first / "sub" / "c")
    assert digest(first) != digest(second)
    (first / "sub" / "c").rename(first / "sub" / "a")
    (first / "sub" / "a").write_text("changed")
    assert digest(first) != digest(second)


def test_a_source_tells_neither_path_nor_user(tmp_path: Path) -> None:
    path = tmp_path / "clip.bin"
    path.write_bytes(b"frames")
    text = strict_json(provenance(source=source(path)))
    assert str(tmp_path) not in text
    assert f"/{getpass.getuser()}" not in text
    assert '"clip.bin"' in text
