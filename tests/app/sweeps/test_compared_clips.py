"""Settings are compared over the same clips, whatever failed or is left to do."""

from __future__ import annotations

import math

from app.sweeps.sections import best, over_all
from app.sweeps.summary import Setting, Summary
from app.sweeps.table import Row

STEADY: Setting = (("method", "steady"),)
FAILING: Setting = (("method", "failing"),)


def summary(*jobs: tuple[str, str, dict[str, float | None] | None]) -> Summary:
    """Of clip, method and measures; None: the job failed."""
    rows = [
        Row(
            job=f"{clip} {method}",
            clip=clip,
            clip_sha256=clip,
            state="failed" if measures is None else "finished",
            reason="",
            settings={"method": method},
            measures=measures or {},
            costs={"seconds": 10.0 if clip == "hard" else 1.0},
        )
        for clip, method, measures in jobs
    ]
    return Summary.of(rows, ["method"])


def test_a_setting_that_fails_on_the_hard_clip_is_not_better_for_it() -> None:
    found = summary(
        ("easy", "steady", {"psnr": 38.0, "ssim": 0.9}),
        ("easy", "failing", {"psnr": 35.0, "ssim": 0.8}),
        ("hard", "steady", {"psnr": 28.0, "ssim": 0.7}),
        ("hard", "failing", None),
    )
    assert found.best("psnr") == STEADY
    assert found.spread(STEADY, "psnr").mean == 38.0
    assert found.spread(FAILING, "psnr").mean == 35.0
    # Of one clip, what there is.
    assert found.best("psnr", "hard") == STEADY
    assert found.spread(STEADY, "psnr", "hard").mean == 28.0
    means = over_all(found, ["psnr", "ssim"])
    assert [row[:3] for row in means.rows] == [("method steady", 1, 38.0), ("method failing", 1, 35.0)]
    assert "psnr, ssim without hard" in means.note
    table = best(found, ["psnr"])
    assert table.rows == (("psnr", "1 of 2 clips", "method steady", 38.0),)
    assert "psnr without hard" in table.note
    # The median time, too, is of the clip that both have.
    assert {point.seconds for point in found.diagram("psnr").points} == {1.0}


def test_where_every_setting_has_every_clip_nothing_is_left_out() -> None:
    found = summary(
        ("easy", "steady", {"psnr": 38.0}),
        ("easy", "failing", {"psnr": 35.0}),
        ("hard", "steady", {"psnr": 28.0}),
        ("hard", "failing", {"psnr": 30.0}),
    )
    means, table = over_all(found, ["psnr"]), best(found, ["psnr"])
    assert [row[:3] for row in means.rows] == [("method steady", 2, 33.0), ("method failing", 2, 32.5)]
    assert "without" not in means.note
    assert table.rows == (("psnr", "all clips", "method steady", 33.0),)
    assert table.note == ""


def test_a_measure_that_a_setting_never_has_is_compared_among_the_others() -> None:
    found = summary(
        ("easy", "steady", {"psnr": 38.0, "lpips": 0.1}),
        ("easy", "failing", {"psnr": 35.0, "lpips": None}),
        ("hard", "steady", {"psnr": 28.0, "lpips": 0.3}),
    )
    assert found.compared_clips("psnr") == ("easy",)
    assert found.compared_clips("lpips") == ("easy", "hard")
    assert found.spread(STEADY, "lpips").mean == 0.2
    assert found.spread(FAILING, "lpips").count == 0
    assert found.best("lpips") == STEADY


def test_settings_without_a_clip_in_common_are_not_compared() -> None:
    found = summary(("easy", "failing", {"psnr": 38.0}), ("hard", "steady", {"psnr": 28.0}))
    assert found.best("psnr") is None
    means = over_all(found, ["psnr"])
    assert all(row[1] == 0 and math.isnan(row[2]) for row in means.rows)  # type: ignore[arg-type]
    assert "psnr without easy, hard" in means.note
    assert found.diagram("psnr").points == ()
