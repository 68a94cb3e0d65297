"""Which device trains: what is missing is said, and a run goes on where it began."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from app.errors import UserError
from app.runs import device
from app.runs.device import choose, missing
from app.runs.run_folder import RunFolder
from app.runs.train_run import device_of
from tests.app.conftest import Cli, request_of


def machine(monkeypatch: pytest.MonkeyPatch, *, cards: int, gsplat: bool, trouble: str = "") -> None:
    """One with these, as far as the choice can see."""
    monkeypatch.setattr(device, "cuda_devices", lambda: cards)
    monkeypatch.setattr(device, "find_spec", lambda name: name if gsplat else None)
    monkeypatch.setattr(device, "_trouble", lambda: trouble)


@pytest.mark.parametrize(
    ("cards", "gsplat", "trouble", "words"),
    [
        (0, True, "", ("driver finds no GPU",)),
        (1, False, "", ("pip install", "gsplat")),
        (0, False, "", ("driver finds no GPU", "pip install")),
        (1, True, "torch finds no GPU", ("torch finds no GPU",)),
    ],
)
def test_what_is_missing_is_named(
    monkeypatch: pytest.MonkeyPatch, cards: int, gsplat: bool, trouble: str, words: tuple[str, ...]
) -> None:
    machine(monkeypatch, cards=cards, gsplat=gsplat, trouble=trouble)
    auto = choose("auto")
    with pytest.raises(UserError) as refused:
        choose("cuda")
    assert auto.device == choose("cpu").device == "cpu"
    for word in ("--device cpu", *words):
        assert word in str(refused.value)
    assert all(word in auto.why for word in words)
    assert "\n" not in str(refused.value)


def test_a_whole_machine_trains_on_its_card(monkeypatch: pytest.MonkeyPatch) -> None:
    machine(monkeypatch, cards=1, gsplat=True)
    assert missing() == ""
    assert choose("auto").device == choose("cuda").device == "cuda"
    assert choose("cpu").device == "cpu"


def test_a_run_goes_on_where_it_began(
    monkeypatch: pytest.MonkeyPatch, runs: dict[str, Path], clip_path: Path
) -> None:
    machine(monkeypatch, cards=1, gsplat=True)
    request = replace(request_of(clip_path, runs["original"]), resume=True, device="auto")
    assert RunFolder(runs["original"]).record().device == "cpu"
    assert device_of(request).device == "cpu"
    with pytest.raises(UserError, match="expected the run's device cpu, got cuda"):
        device_of(replace(request, device="cuda"))


def test_the_command_says_which_and_why(clip_path: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    lacks = missing()
    if not lacks:
        pytest.skip("nothing is missing here")
    call = vesselsplat("train", clip_path, "--run", tmp_path / "run", "--iterations", "2")
    assert f"on cpu ({lacks})" in call.out
    refused = vesselsplat("train", clip_path, "--run", tmp_path / "other", "--device", "cuda")
    assert (refused.code, refused.error.count("\n")) == (2, 1)
    assert lacks in refused.error
    assert not (tmp_path / "other").exists()
