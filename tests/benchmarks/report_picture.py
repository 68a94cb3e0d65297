"""The picture of README.md from a report: python -m tests.benchmarks.report_picture JSON PNG"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from app.report.plots import write_diagrams
from app.report.saved import read_report


def main(report: Path, picture: Path) -> None:
    saved = read_report(report)
    (enhancement,) = saved.sections["enhancement"].plates[0].diagrams
    psnr, _, depth, *_ = saved.sections["training"].plates[0].diagrams
    named = [
        replace(enhancement, measure=f"enhancement: {enhancement.measure}"),
        *(replace(one, measure=f"reconstruction: {one.measure}") for one in (psnr, depth)),
    ]
    write_diagrams(picture, named, f"Error against run time, {saved.clip}: Pareto fronts and defaults")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
