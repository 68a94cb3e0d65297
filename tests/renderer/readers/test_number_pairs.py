"""Files pair with frames by number; where the two count from different starts, in order or not at all."""

from __future__ import annotations

import pytest

from renderer.readers.number_pairs import NumberPairs, number_pairs, numbers_of

TEN = range(1, 11)


@pytest.mark.parametrize(
    ("frames", "files", "pairs"),
    [
        (TEN, range(1, 11), {number: number for number in TEN}),
        (TEN, (3, 7), {3: 3, 7: 7}),
        ((4, 5), range(40), {4: 4, 5: 5}),
        ((1, 2, 4, 5, 6, 7), (1, 2, 3, 4, 6, 7), {1: 1, 2: 2, 4: 4, 6: 6, 7: 7}),
        (TEN, range(10), {number: number - 1 for number in TEN}),
        (range(10), TEN, {number: number + 1 for number in range(10)}),
        ((101, 103, 104), (1, 3, 4), {101: 1, 103: 3, 104: 4}),
    ],
)
def test_each_frame_gets_the_file_that_is_meant(frames, files, pairs):
    frames, files = tuple(frames), tuple(files)
    found = number_pairs(frames, files)
    assert found is not None
    assert {frames[frame]: files[file] for frame, file in found.files.items()} == pairs
    assert all(frames[frame] == files[file] + found.shift for frame, file in found.files.items())


@pytest.mark.parametrize(
    ("frames", "files"),
    [
        (TEN, range(9)),
        ((1, 3, 5, 7), range(4)),
        ((0, 5, 10, 15), range(4)),
        (range(101, 111), range(105, 115)),
        (range(101, 111), range(201, 211)),
    ],
)
def test_numbers_that_fit_as_well_shifted_tell_nothing(frames, files):
    assert number_pairs(tuple(frames), tuple(files)) is None


def test_order_does_not_matter():
    assert number_pairs((3, 1, 2), (2, 0, 1)) == NumberPairs({0: 0, 1: 1, 2: 2}, 1)


def test_a_name_counts_by_its_last_number():
    assert numbers_of(["left_2_010.png", "left_2_011.png"]) == [10, 11]
    assert numbers_of(["a.png", "b1.png"]) is None
    assert numbers_of(["a1.png", "b1.png"]) is None
