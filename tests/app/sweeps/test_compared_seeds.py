"""Settings are compared over the same seeds of a clip, whatever failed or is left to do."""

from __future__ import annotations

import math

from app.sweeps.sections import best, by_clip, over_all
from app.sweeps.summary import Setting, Summary
from app.sweeps.table import Row

STEADY: Setting = (("method", "steady"),)
FAILING: Setting = (("method", "failing"),)


def summary(*jobs: tuple[str, str, int, float | None]) -> Summary:
    """Of clip, method, seed and PSNR; None: the job failed."""
    rows = [
        Row(
            job=f"{clip} {method} {seed}",
            clip=clip,
            clip_sha256=clip,
            state="failed" if psnr is None else "finished",
            reason="",
            settings={"method": method, "seed": seed},
            measures={"psnr": psnr},
            costs={"seconds": 10.0 if seed else 1.0},
        )
        for clip, method, seed, psnr in jobs
    ]
    return Summary.of(rows, ["method"])


def test_a_setting_that_fails_with_the_hard_seed_is_not_better_for_it() -> None:
    found = summary(
        ("a", "failing", 0, 30.0),
        ("a", "failing", 1, None),
        ("a", "steady", 0, 31.0),
        ("a", "steady", 1, 21.0),
    )
    assert found.best("psnr") == found.best("psnr", "a") == STEADY
    means, table, clips = over_all(found, ["psnr"]), best(found, ["psnr"]), by_clip(found, ["psnr"])
    assert [row[:3] for row in means.rows] == [("method failing", 1, 30.0), ("method steady", 1, 31.0)]
    assert [row[2:4] for row in clips.rows] == [(1, 30.0), (1, 31.0)]
    assert table.rows == (("psnr", "all clips", "method steady", 31.0),)
    for one in (means, table, clips):
        assert "seeds with which every setting has the measure: psnr of a." in one.note
    # The median time, too, is of the seed that both have.
    assert {point.seconds for point in found.diagram("psnr").points} == {1.0}


def test_a_clip_without_a_seed_in_common_is_not_compared() -> None:
    found = summary(
        ("a", "steady", 0, 30.0),
        ("a", "failing", 1, 40.0),
        ("b", "steady", 0, 28.0),
        ("b", "failing", 0, 26.0),
    )
    assert found.compared_clips("psnr") == ("b",)
    assert found.spread(STEADY, "psnr").mean == 28.0
    assert math.isnan(found.spread(FAILING, "psnr", "a").mean)
    assert "psnr without a" in over_all(found, ["psnr"]).note
    assert found.difference(FAILING, STEADY, "psnr").spread.count == 1


def test_where_every_setting_has_every_seed_nothing_is_said_of_them() -> None:
    found = summary(
        ("a", "steady", 0, 30.0),
        ("a", "steady", 1, 20.0),
        ("a", "failing", 0, 28.0),
        ("a", "failing", 1, 26.0),
        ("b", "steady", 0, 28.0),
    )
    assert found.uneven_clips("psnr") == ()
    assert found.best("psnr") == FAILING
    # Of a clip that one setting has, what there is.
    assert found.best("psnr", "b") == STEADY
    assert "seeds with" not in over_all(found, ["psnr"]).note
