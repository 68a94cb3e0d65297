"""A clip in parts: what ends one, and what lets it go on."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

from renderer.poses.parts import MOST_BRIDGED, Lost, parts_of


@dataclass(eq=False)
class Place:
    """Frames of one letter; capitals show all of a place, small letters a little of it."""

    letter: str
    frames: list[int] = field(default_factory=list)

    @property
    def last(self) -> int:
        return self.frames[-1]

    def __len__(self) -> int:
        return len(self.frames)

    def follow(self, picture, share=0.0):
        if picture.shown.upper() != self.letter or (share and picture.shown.islower()):
            raise Lost("another place")
        self.frames.append(picture.index)


def begun(picture):
    if not picture.shown.isupper():
        raise Lost("nothing")
    return Place(picture.shown, [picture.index])


def walked(shown):
    """Letter and frames of each part, and the frames that are in none."""
    parts, lost = parts_of((SimpleNamespace(index=at, shown=each) for at, each in enumerate(shown)), begun)
    return [(part.letter, part.frames) for part in parts], {each.frame: each.why for each in lost}


def test_a_part_goes_on_behind_a_view_that_is_covered_for_long():
    parts, lost = walked("A" * 9 + "." * 40 + "A" * 3)
    assert parts == [("A", [*range(9), 49, 50, 51])]
    assert sorted(lost) == list(range(9, 49))
    assert set(lost.values()) == {"another place", "nothing"}


def test_what_covers_it_is_a_part_of_its_own_and_ends_with_the_first_frame_that_is_free():
    parts, lost = walked("A" * 9 + "B" * 8 + "A" * 3)
    first = 9 + MOST_BRIDGED + 1
    assert parts == [("A", [*range(9), 17, 18, 19]), ("B", [*range(first, 17)])]
    assert sorted(lost) == list(range(9, first))


def test_a_little_of_a_place_is_enough_behind_a_few_frames_alone():
    assert walked("A" * 9 + "." * MOST_BRIDGED + "a")[0] == [("A", [*range(9), 9 + MOST_BRIDGED])]
    assert walked("A" * 9 + "." * (MOST_BRIDGED + 1) + "a")[0] == [("A", [*range(9)])]


def test_a_part_of_few_frames_does_not_go_on():
    assert [letter for letter, _ in walked("A" * 5 + "." * 9 + "A" * 9)[0]] == ["A", "A"]


def test_the_longest_part_goes_on_not_the_first():
    parts, _ = walked("A" * 9 + "B" * 20 + "." * 9 + "AAABBB")
    assert [letter for letter, _ in parts] == ["A", "B", "A"]
    assert parts[1][1][-3:] == [41, 42, 43]
