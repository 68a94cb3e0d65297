"""The picture of README.md from a report: python -m tests.benchmarks.report_picture JSON PNG"""

from __future__ import annotations

import sys
from pathlib import Path

from app.report.plots import diagrams_figure
from app.report.section import read_report


def main(report: Path, picture: Path) -> None:
    saved = read_report(report)
    plate = saved.sections["training"].plates[0]
    title = f"{plate.title}, {saved.clip}: held-out frames"
    diagrams_figure(plate.diagrams[:3], title).savefig(picture, dpi=150)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
