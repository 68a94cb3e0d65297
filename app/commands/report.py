"""`vesselsplat report`: error against run time, contrast against noise, stability, omissions, on one page."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from app.console.flags import positive
from app.errors import UserError
from app.files.atomic import filled
from app.files.provenance import plain, provenance, strict_json
from app.files.records import Source
from app.report.bench import PARTS, Bench, Clock, Part, machine, opened
from app.report.diagrams import Point, within_budget, within_error
from app.report.page import page
from app.report.section import REPORT, Section
from enhance import ImageError
from renderer.clip import ClipError
from renderer.listing import count
from renderer.train.trainer import TrainingError

MINUTES, MINUTES_WITH_CLIP = 29.0, 54.0
"""What may be begun, so that 30 and 60 suffice on two cores."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    names = ",".join(part.name for part in PARTS)
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/report"),
        metavar="DIR",
        help="folder to write into (default out/report)",
    )
    parser.add_argument(
        "--clip", type=Path, metavar="CLIP", help="measure on this clip instead of the phantom"
    )
    parser.add_argument(
        "--scenes", type=Path, nargs="+", default=[], metavar="PATH",
        help="further clips, images and videos, for the omissions and for Table 3",
    )  # fmt: skip
    parser.add_argument(
        "--parts", metavar="NAMES", default=names, help=f"any of {names}, separated by commas"
    )
    parser.add_argument(
        "--minutes", type=positive, metavar="F", help="total time to spend (default 29; with --clip 54)"
    )
    parser.add_argument(
        "--budget",
        metavar="TIME",
        help="with the report, print the best settings within this time, such as 10ms",
    )
    parser.add_argument(
        "--error",
        type=positive,
        metavar="F",
        help="the same of the fastest settings within this error",
    )


def run(flags: argparse.Namespace) -> None:
    parts, budget = _chosen(flags.parts), _seconds(flags.budget)
    minutes = flags.minutes or (MINUTES_WITH_CLIP if flags.clip else MINUTES)
    for path in flags.scenes:
        if not path.exists():
            raise UserError(f"--scenes: expected a clip, image or video, got no such file: {path}")
    began, facts = time.monotonic(), machine()
    _say(f"{count(len(parts), 'part')}, about {minutes:g} min in all (--minutes spends less)")
    with filled(flags.out) as staging, opened(flags.clip, tuple(flags.scenes), _say) as bench:
        sections, seconds = measured(bench, parts, 60 * minutes)
        clip = {"name": "phantom"} if flags.clip is None else plain(Source.of(flags.clip))
        report = provenance(machine=facts, clip=clip, seconds=seconds, parts=sections)
        (staging / REPORT).write_text(strict_json(report, indent=1), encoding="utf-8")
        said = {"clip": clip["name"], "measured": f"{report['utc']}, in {sum(seconds.values()):.0f} s"}
        (staging / "report.html").write_text(page(sections, said | facts), encoding="utf-8")
    sys.stdout.write(f"{flags.out}: report.html, report.json in {time.monotonic() - began:.0f} s\n")
    advised = [*advice(sections, budget, flags.error)]
    if not advised and (budget is not None or flags.error is not None):
        advised = ["no advice: none of these parts has measured the errors of settings against their times"]
    sys.stdout.writelines(f"{line}\n" for line in advised)


def measured(
    bench: Bench, parts: Sequence[Part], seconds: float
) -> tuple[dict[str, Section], dict[str, float]]:
    """The section of each part, and the seconds it took; what one leaves of its time, the next ones have.

    The section of a part that fails says why, and the others go on.
    """
    measures = [part.measure for part in parts]
    sections, taken, until = {}, {}, time.monotonic() + seconds
    for place, (part, measure) in enumerate(zip(parts, measures, strict=True)):
        began = time.monotonic()
        _say(f"part {place + 1} of {len(parts)}: {part.name}")
        share = part.share / sum(each.share for each in parts[place:])
        try:
            sections[part.name] = measure(bench, Clock.of(share * max(0.0, until - began)))
        except (ClipError, ImageError, TrainingError, UserError) as error:
            # Hours may have gone into the other parts.
            reason = str(error).replace(str(bench.clip_path), bench.clip_path.name)
            sections[part.name] = Section(title=part.name, not_measured=(reason,))
        taken[part.name] = time.monotonic() - began
        for reason in sections[part.name].not_measured:
            _say(f"not measured: {reason}")
        _say(f"{part.name}: {taken[part.name]:.0f} s")
    return sections, taken


def _chosen(text: str) -> list[Part]:
    names, known = [name.strip() for name in text.split(",")], {part.name: part for part in PARTS}
    for name in names:
        if name not in known:
            raise UserError(f"--parts: expected some of {','.join(known)}, got {name!r}")
    return [part for part in PARTS if part.name in names]


def _seconds(text: str | None) -> float | None:
    if text is None:
        return None
    found = re.fullmatch(r"\s*([0-9]*\.?[0-9]+)\s*(ms|s|min)?\s*", text)
    seconds = float(found[1]) * {"ms": 1e-3, "s": 1.0, "min": 60.0, None: 1.0}[found[2]] if found else 0.0
    if not seconds > 0:
        raise UserError(f"--budget: expected a time such as 10ms, 2s or 1min, got {text!r}")
    return seconds


def advice(sections: Mapping[str, Section], budget: float | None, error: float | None) -> Iterator[str]:
    """A line for each diagram and bound; `budget` in seconds, `error` in the unit of each diagram.

    An error bound says nothing about measures of which more is better.
    """
    for section in sections.values():
        for plate in section.plates:
            for diagram in plate.diagrams:
                where = f"{plate.title}, {diagram.measure}"
                if budget is not None:
                    found = within_budget(diagram, budget)
                    yield f"{where}, within {_duration(budget)}: {_point(found)}"
                if error is not None and not diagram.more_is_better:
                    yield f"{where}, at most {error:g}: {_point(within_error(diagram, error))}"


def _point(point: Point | None) -> str:
    if point is None:
        return "none of the measured settings"
    default = ", the default" if point.is_default else ""
    return f"{point.series}, {point.setting} ({point.error:.3g} in {_duration(point.seconds)}){default}"


def _duration(seconds: float) -> str:
    return f"{1000 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def _say(line: str) -> None:
    sys.stderr.write(f"report: {line}\n")
    sys.stderr.flush()
