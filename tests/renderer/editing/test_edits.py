"""Edits as sets, their history, and what they leave of a model at every time."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from renderer.editing.edits import Edits
from renderer.editing.history import MOST, History
from renderer.editing.mask import Mask
from renderer.gaussians import DynamicGaussians
from tests.renderer.editing.models import COUNT, models

MODELS = models()


def masks(count: int = 13) -> st.SearchStrategy[Mask]:
    return st.integers(0, (1 << count) - 1).map(lambda bits: Mask(count, bits))


def chosen(mask: Mask) -> set[int]:
    return set(mask.indices().tolist())


@given(masks(), masks())
def test_masks_combine_as_sets_do(one: Mask, other: Mask) -> None:
    everything = set(range(13))
    assert chosen(one | other) == chosen(one) | chosen(other)
    assert chosen(one & other) == chosen(one) & chosen(other)
    assert chosen(one - other) == chosen(one) - chosen(other)
    assert chosen(~one) == everything - chosen(one)
    assert len(one) == len(chosen(one))


@given(st.lists(st.booleans(), max_size=40))
def test_masks_come_back_from_booleans_and_bytes(given_: list[bool]) -> None:
    mask = Mask.of(np.array(given_, np.bool_))
    assert mask.booleans().tolist() == given_
    assert Mask.unpacked(mask.count, mask.packed()) == mask
    assert len(mask.packed()) == -(-len(given_) // 8)


def test_masks_of_other_models_are_refused() -> None:
    with pytest.raises(ValueError, match="of 7 Gaussians"):
        Mask(7, 1 << 7)
    with pytest.raises(ValueError, match="7 and 8"):
        Mask(7) | Mask(8)


@given(masks(), masks(), masks(), st.sampled_from(["replace", "add", "subtract", "intersect"]))
def test_only_what_is_seen_is_selected_and_changed(
    deleted: Mask, hidden: Mask, found: Mask, how: str
) -> None:
    """Each step against its meaning in sets."""
    before = Edits(deleted, hidden - deleted, (found & ~deleted) - hidden)
    seen = set(range(13)) - chosen(deleted) - chosen(hidden)
    new = Mask(13, 0b1010110010110)
    after = before.selecting(new, how)  # type: ignore[arg-type]
    old, fresh = chosen(before.selected), chosen(new) & seen
    meant = {"replace": fresh, "add": old | fresh, "subtract": old - fresh, "intersect": old & fresh}
    assert chosen(after.selected) == meant[how]
    for step in (Edits.deleting, Edits.cropping, Edits.hiding, Edits.showing, Edits.inverted):
        edits = step(before)
        assert chosen(edits.selected) <= chosen(edits.visible)
        assert chosen(edits.deleted) >= chosen(deleted)
        assert not chosen(edits.deleted) & (chosen(hidden) - chosen(deleted))
    assert chosen(before.deleting().visible) == seen - old
    assert chosen(before.cropping().visible) == old
    assert chosen(before.hiding().visible) == seen - old
    assert chosen(before.hiding().showing().visible) == set(range(13)) - chosen(deleted)
    assert chosen(before.inverted().selected) == seen - old
    assert chosen(before.selecting_all().selected) == seen
    assert not before.selecting_none().selected


@pytest.mark.parametrize("kind", MODELS)
def test_what_is_kept_moves_as_before_at_every_time(kind: str) -> None:
    """Also where motion is shared by neighbours that are gone."""
    model = MODELS[kind]
    rng = np.random.default_rng(1)
    for share in (0.0, 0.03, 0.5, 1.0):
        lost = Mask.of(rng.uniform(size=COUNT) < share)
        edits = Edits.none(COUNT).selecting(lost, "replace").deleting()
        kept, edited = edits.visible.indices(), edits.applied(model)
        assert len(edited) == COUNT - len(lost)
        for time in np.linspace(0, 1, 9):
            before, after = model.at(float(time)), edited.at(float(time))
            for item in fields(before):
                old, new = getattr(before, item.name), getattr(after, item.name)
                np.testing.assert_array_equal(old[kept], new)


def test_an_edited_model_is_a_model_of_its_own() -> None:
    edits = Edits.none(COUNT).selecting(Mask(COUNT, 7), "replace").hiding()
    edited = edits.applied(MODELS["spline"])
    again = edits.applied(MODELS["spline"])
    assert digest(edited) == digest(again) != digest(MODELS["spline"])
    assert edits.showing().applied(MODELS["spline"]) is MODELS["spline"]
    with pytest.raises(ValueError, match="150 Gaussians, got one of 147"):
        edits.applied(edited)


def digest(model: DynamicGaussians) -> str:
    total = hashlib.sha256()
    for name, array in model.arrays().items():
        total.update(name.encode() + str(array.shape).encode() + array.tobytes())
    return total.hexdigest()


FEWEST = 40
"""Gaussians that are left, so that there is always something to do."""
Step = Callable[[Edits, random.Random], Edits]
STEPS: tuple[Step, ...] = (
    lambda edits, draw: edits.selecting(Mask(COUNT, draw.getrandbits(COUNT)), "replace"),
    lambda edits, draw: edits.selecting(Mask(COUNT, draw.getrandbits(COUNT)), "add"),
    lambda edits, draw: edits.selecting(few(draw), "add"),
    lambda edits, draw: edits.selecting(few(draw), "replace"),
    lambda edits, draw: edits.selecting(Mask(COUNT, draw.getrandbits(COUNT)), "subtract"),
    lambda edits, draw: edits.selecting(Mask(COUNT, draw.getrandbits(COUNT)), "intersect"),
    lambda edits, draw: edits.selecting_all() if draw.random() < 0.1 else edits.selecting_none(),
    lambda edits, draw: edits.inverted(),
    lambda edits, draw: edits.deleting() if len(edits.visible - edits.selected) > FEWEST else edits,
    lambda edits, draw: edits.cropping() if len(edits.selected) > FEWEST else edits,
    lambda edits, draw: edits.hiding(),
    lambda edits, draw: edits.showing(),
)


def few(draw: random.Random) -> Mask:
    return Mask(COUNT, sum({1 << draw.randrange(COUNT) for _ in range(4)}))


@settings(max_examples=20)
@given(st.integers(0, 2**32), st.sampled_from(list(MODELS)))
def test_undo_and_redo_of_200_edits_give_identical_bytes(seed: int, kind: str) -> None:
    model, draw = MODELS[kind], random.Random(seed)
    history = History(Edits.none(COUNT))
    told = [(history.present, digest(model))]
    for _ in range(2000):
        step = draw.choice(STEPS)
        after = history.then(step(history.present, draw))
        if after is not history:
            history = after
            told.append((history.present, digest(history.present.applied(model))))
        if len(told) > 200:
            break
    assert len(told) == 201
    for edits, expected in reversed(told[:-1]):
        history = history.undone()
        assert history.present == edits
        assert digest(history.present.applied(model)) == expected
    assert history.undone() is history
    assert history.present.applied(model) is model
    for edits, expected in told[1:]:
        history = history.redone()
        assert history.present == edits
        assert digest(history.present.applied(model)) == expected
    assert history.redone() is history


def test_a_new_edit_ends_what_was_undone_and_nothing_is_no_step() -> None:
    start = History(Edits.none(9))
    one = start.then(start.present.selecting_all())
    assert one.then(one.present) is one
    other = one.undone().then(Edits.none(9).selecting(Mask(9, 3), "replace"))
    assert other.future == ()
    assert other.undone() == History(start.present, (), (other.present,))


def test_the_history_is_bounded() -> None:
    history = History(Edits.none(2000))
    for place in range(MOST + 50):
        history = history.then(history.present.selecting(Mask(2000, 1 << place), "replace"))
    assert len(history.past) == MOST
