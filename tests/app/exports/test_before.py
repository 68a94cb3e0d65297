"""Files of every kind that an earlier version made come again; `make_before` says how they were made."""

from __future__ import annotations

import json
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pytest

from app.errors import UserError
from app.exports.replay.again import replay
from app.exports.replay.difference import Array, arrays

BEFORE = Path(__file__).with_name("before")
FILES = sorted(
    path.name
    for path in BEFORE.iterdir()
    if path.suffix
    in (".png", ".npy", ".tiff", ".mp4", ".ply", ".csv", ".html", ".glb", ".obj", ".npz", ".usdc", ".4dgs")
    and path.name not in ("photo.png", "window.png")
)
SOURCES = tuple(BEFORE / name for name in ("clip", "clip/images", "run", "mip", "photo.png", "splats.ply"))
GREY_LEVELS = 2
"""By which another processor or library may round a picture otherwise; drawn letters, and what a codec makes
of that, may be further off at a few places."""
FEW = 0.02
LAST_BITS = 4 * float(np.finfo(np.float32).eps)
SAID_OTHERWISE = 1e-3
"""Relative, of floats."""
CHANGED = ("vessel.tiff",)
"""Since 0.2.0 `vessel` looks for blood on another grid: a file that it made before says who made it."""
REDRAWN = ("arrays.npz", "depth.npy", "depth16.png", "surface.glb", "surface.obj", "surface.ply")
"""Since 0.3.0 the CPU reckons a splat's exponent in another form: depths that it drew before are a few last
bits off, and who made them is said."""
REDRAWN_BITS = 5e-6
"""Of the largest float in the file; whole numbers of 16 bits are off by one at most."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.gl) if "opengl" in name else name for name in FILES]
)
def test_it_comes_again(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BEFORE)  # The runs name their clip from here.
    replayed = replay(BEFORE / name, SOURCES, tmp_path / name)
    others = [reason for reason in replayed.reasons if "VesselSplat" not in reason]
    same = replayed.difference.is_none or is_last_bits(BEFORE / name, tmp_path / name)
    assert replayed.difference.unlike == ""
    if name in CHANGED:
        assert any("VesselSplat 0.1.0" in reason for reason in replayed.reasons)
        return
    if name in REDRAWN and not same:
        assert any("made with VesselSplat 0." in reason for reason in replayed.reasons)
        assert is_redrawn(BEFORE / name, tmp_path / name), replayed.sentence
        return
    assert same or others, replayed.sentence
    for one, other in zip_longest(arrays(BEFORE / name), arrays(tmp_path / name)):
        assert one is not None
        assert other is not None
        assert is_near(one, other), replayed.sentence


def is_last_bits(before: Path, again: Path) -> bool:
    """Floats alone, as apart as kernels made for another kind of processor leave them."""
    pairs = list(zip_longest(arrays(before), arrays(again)))
    if any(one is None or other is None or one.dtype != np.float32 for one, other in pairs):
        return False
    return all(np.allclose(one, other, rtol=LAST_BITS, atol=0, equal_nan=True) for one, other in pairs)


def is_redrawn(before: Path, again: Path) -> bool:
    pairs = list(zip_longest(arrays(before), arrays(again)))
    floats = [(one, other) for one, other in pairs if one.dtype.kind == "f"]
    largest = max((float(np.nanmax(np.abs(one), initial=0)) for one, _ in floats), default=0.0)
    whole = [(one, other) for one, other in pairs if one.dtype.kind != "f"]
    return all(
        np.allclose(one, other, rtol=0, atol=REDRAWN_BITS * largest, equal_nan=True) for one, other in floats
    ) and all((np.abs(one.astype(int) - other) <= (one.dtype == np.uint16)).all() for one, other in whole)


def is_near(one: Array, other: Array) -> bool:
    if one.dtype.kind == "f":
        return bool(np.allclose(one, other, rtol=SAID_OTHERWISE, atol=SAID_OTHERWISE, equal_nan=True))
    away = np.abs(one.astype(int) - other)
    return bool((away > GREY_LEVELS).mean() < FEW)


def test_the_window_is_told_from_what_can_be_made_again(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="the whole window"):
        replay(BEFORE / "window.png", SOURCES, tmp_path / "window.png")


def test_every_kind_is_there() -> None:
    """Seventeen kinds of file, several of them of more than one view or arrangement."""
    assert len(FILES) >= 20


@pytest.mark.parametrize("kind", ["another-kind", ""])
def test_another_kind_of_processor_is_a_reason_where_the_record_has_one(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(BEFORE)
    facts = json.loads((BEFORE / "depth.npy.json").read_text())
    facts["libraries"]["processor"] = f"x86_64 {kind}".rstrip()
    (tmp_path / "old.npy.json").write_text(json.dumps(facts))
    np.save(tmp_path / "old.npy", np.load(BEFORE / "depth.npy") + np.float32(1))
    replayed = replay(tmp_path / "old.npy", SOURCES, tmp_path / "new.npy")
    assert any("processor x86_64 another-kind" in reason for reason in replayed.reasons) == bool(kind)
