"""`vesselsplat protocol CLIP... --out DIR`: the field's comparison, beside what has been published."""

from __future__ import annotations

import argparse
import json
import sys
import tomllib
from importlib.resources import files
from pathlib import Path

from app.commands.sweep import NO_ENGINE, add_engine_flags, carry_out, print_table, require_all_done
from app.console.flags import refuse
from app.errors import UserError
from app.files.legible import require_utf8
from app.files.provenance import provenance, strict_json
from app.report.section import Cell, Column, Table
from app.sweeps.engines.opening import require_engine
from app.sweeps.plan import planned, read_sweep
from app.sweeps.published import of_clip
from app.sweeps.spec import spec_of
from app.sweeps.summary import Summary
from app.sweeps.table import rows

SPEC = "protocol.toml"


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "clips", metavar="CLIP", nargs="*", type=Path, help="clips with depth, such as EndoNeRF's"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder to write into; the same command resumes"
    )
    parser.add_argument("--print", action="store_true", help="print the sweep that it runs, as TOML")
    add_engine_flags(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    text = files("app.sweeps").joinpath(SPEC).read_text(encoding="utf-8")
    clips = [str(path.absolute()) for path in flags.clips]
    for clip in clips:
        require_utf8(Path(clip))
    if flags.print:
        refuse(flags, {"out": None, "json": False, **NO_ENGINE}, "--print")
        # A list of texts is the same in JSON and in TOML, but for the escape of what Unicode has beyond
        # 16 bits, and for DEL.
        listed = json.dumps(clips, ensure_ascii=False).replace("\x7f", "\\u007f")
        sys.stdout.write(text.replace("clips = []", f"clips = {listed}"))
        return
    if not flags.clips or flags.out is None:
        raise UserError("expected CLIP... and --out DIR, or --print")
    require_engine(flags.on)
    spec = spec_of(tomllib.loads(text) | {"clips": clips}, Path(SPEC))
    plan = planned(spec, Path(SPEC))
    carry_out(plan, flags.out, on=flags.on, workers=flags.workers, retry=flags.retry)
    table = compared(flags.out)
    if flags.json:
        sys.stdout.write(strict_json(provenance(table=table)) + "\n")
    else:
        print_table(table)
    require_all_done(plan, flags.out)


def compared(folder: Path) -> Table:
    """Rows of this program, means over seeds, above the published ones of the same clip."""
    record = read_sweep(folder)
    summary = Summary.of(rows(record, folder), record.varied)
    lines: list[tuple[Cell, ...]] = []
    for clip in summary.clips:
        for setting in summary.settings:
            psnr, ssim, lpips, depth, seconds = (
                summary.spread(setting, name, clip)
                for name in ("psnr", "ssim", "lpips", "depth_rmse_mm", "wall_seconds")
            )
            method = str(dict(setting)["method"])
            measured = (psnr.mean, psnr.deviation, ssim.mean, lpips.mean, depth.mean, seconds.mean)
            lines.append((clip, method, *measured, f"measured here, {psnr.count} seeds"))
        for one in of_clip(clip):
            lines.append((clip, one.method, one.psnr, None, one.ssim, one.lpips, None, None, one.source))
    names = ("clip", "method", "PSNR dB", "±", "SSIM", "LPIPS", "depth mm", "seconds", "source")
    return Table(
        title="The field's comparison",
        columns=tuple(map(Column, names)),
        rows=tuple(lines),
        note="Frames with (i - 1) % 8 == 0, masked images, mean over all pixels. Published rows were not "
        "measured here: depth, masks and machines differ between sources.",
    )
