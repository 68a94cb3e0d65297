"""`vesselsplat enhance INPUT... OUTPUT`: images in, enhanced images out."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.commands.method_flags import add_settings, params_of
from app.console.flags import add_fields, parameters
from app.console.older_files import say_older
from app.console.progress import progress
from app.enhancement.batch import Item, enhance_batch, items_in
from app.enhancement.dicom_files import is_dicom_name, require_dicom
from app.enhancement.enhance_files import Setting, Stream, enhance_into
from app.enhancement.kept_inputs import files_of, homes, identities, require_other
from app.enhancement.methods import METHODS, PAPER
from app.enhancement.settable import PIXELS, SCOPES
from app.errors import UserError
from app.exports.replay.enhanced_already import enhanced_already
from app.files.codecs import MP4, WEBM, ending_of
from app.files.dicom.choices import DEIDENTIFIED, DicomChoices
from app.files.image_files import is_image, is_still
from app.files.image_series import Series, open_series
from app.files.provenance import provenance, strict_json
from app.files.stepping import ahead, run_to_end
from app.files.video_encoder import codec_for
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.file_kinds import VIDEOS
from renderer.readers.image_files.pictures import common_size

PICTURES = frozenset({".exr", ".gif", ".jxl", ".psd", ".svg"})
NOT_WRITTEN = (VIDEOS | CODED | PICTURES) - {MP4, WEBM}
"""Formats that are not written; see `_check_output` for other names."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "inputs", metavar="INPUT", nargs="+", type=Path, help="image, folder of images or video; also DICOM"
    )
    parser.add_argument(
        "output",
        metavar="OUTPUT",
        type=Path,
        help="image, folder, video (.mp4 as H.264, .hevc.mp4, .webm as VP9) or .dcm (DICOM, a still or a "
        "video) to write; with several inputs, the folder for all results",
    )
    parser.add_argument(
        "--recursive",
        action="store_true",
        help="all images and videos below each INPUT, into the same structure in OUTPUT",
    )
    parser.add_argument(
        "--method",
        choices=METHODS,
        default=PAPER,
        help="the paper's method (default), VesselSplat's preset `vessel`, or another method to compare with",
    )
    add_settings(parser, "and --strength, there 0 to 4, default 2.4, and --d-factor, default 0.7")
    parser.add_argument(
        "--statistics",
        choices=SCOPES,
        default="automatic",
        help="take statistics from each image on its own, or for all of them from 16, evenly spread, so that "
        "colours match and nothing flickers (default: the latter of a video, or of images that follow one "
        "another as in a video)",
    )
    parser.add_argument(
        "--pixels",
        choices=PIXELS,
        default=PIXELS[0],
        help="enhance the field of view alone, found inside a dark surround; or every pixel as the paper "
        "does; or every pixel, by statistics without what is black at the border (default automatic)",
    )
    add_fields(parser, ClipOptions, ("deinterlacing", "stereo", "calibration", "bits"))
    group = parser.add_argument_group(
        "of a .dcm file that is written", "by default nothing in it tells who the patient is"
    )
    group.add_argument(
        "--keep-identity", action="store_true", help="keep patient, study and sound of the DICOM file INPUT"
    )
    group.add_argument(
        "--burned-in",
        choices=("yes", "no"),
        help="whether text in the images may tell who the patient is (default: as INPUT says, else yes)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    reading = parameters(ClipOptions, flags)
    setting = Setting(flags.method, params_of(flags), flags.statistics, flags.pixels, reading, _dicom(flags))
    if len(flags.inputs) > 1 or flags.recursive:
        _run_batch(flags, setting)
        return
    (given,) = flags.inputs
    _require_heeded(flags, given)
    series = _warned(open_series(given, reading))
    _check_output(given, flags.output, series, setting.dicom)
    started = time.perf_counter()
    written = run_to_end(enhance_into(flags.output, series, setting, _watched))
    _say(written.notices)
    seconds = time.perf_counter() - started
    if flags.output.is_dir():
        say_older(flags.output, [str(one.output) for one in written.pictures])
    if flags.json:
        shared = _shared(setting) | {"notices": written.notices}
        facts = provenance(**shared, pictures=written.pictures, failed=written.failed, seconds=seconds)
        sys.stdout.write(strict_json(facts) + "\n")
    else:
        sys.stdout.write(f"{flags.output}: {len(written.pictures)} enhanced in {seconds:.1f} s\n")
    if written.failed:
        said = _listed((one.name, one.reason) for one in written.failed)
        raise UserError(f"{len(written.failed)} of {len(series)} images could not be enhanced: {said}")


def _warned(series: Series) -> Series:
    """The images with a notice where the first was enhanced already; they are enhanced all the same."""
    said = enhanced_already(series.sources[0])
    return replace(series, notices=(said, *series.notices)) if said else series


def _warned_item(item: Item) -> Item:
    """The item of a batch with the notice that `_warned` gives, where its source is enhanced already."""
    said = next(map(enhanced_already, files_of(item.source)), "")
    return replace(item, notices=(said, *item.notices)) if said else item


def _require_heeded(flags: argparse.Namespace, given: Path) -> None:
    """Raises UserError: a flag of videos or of several images, for a still or a folder of them."""
    if not given.exists() or (given.is_file() and not is_still(given)):
        return
    _require_video(flags, f"images: {given}" if given.is_dir() else f"one image: {given}")
    if given.is_file() and flags.statistics == "clip":
        raise UserError(f"--statistics clip has no effect on one image: {given}")


def _require_video(flags: argparse.Namespace, what: str) -> None:
    """Raises UserError: a flag that says how videos are read, for what is none."""
    for name in ("deinterlacing", "stereo"):
        if name in flags:
            raise UserError(f"--{name} {vars(flags)[name]} has no effect on {what}")


def _listed(failed: Iterable[tuple[str, str]]) -> str:
    return "; ".join(f"{name} ({reason})" for name, reason in failed)


def _shared(setting: Setting) -> dict[str, Any]:
    """For the JSON: what all pictures have in common."""
    return {"method": setting.method, "params": setting.params, "pixels": setting.pixels}


def _dicom(flags: argparse.Namespace) -> DicomChoices:
    """Raises UserError: no DICOM file is written."""
    told = None if flags.burned_in is None else flags.burned_in == "yes"
    choices = DicomChoices(keep_identity=flags.keep_identity, burned_in=told)
    if choices != DEIDENTIFIED and not is_dicom_name(flags.output):
        name = "--keep-identity" if choices.keep_identity else "--burned-in"
        raise UserError(f"{name} has no effect without a .dcm file as OUTPUT: {flags.output}")
    return choices


def _check_output(given: Path, output: Path, series: Series, choices: DicomChoices) -> None:
    """Refuse what would overwrite the input, or has no place for what comes; a video holds one size."""
    files = tuple(dict.fromkeys((*series.sources, *series.files)))
    taken = identities((given, *files))
    if given.is_dir() or output.is_dir():
        taken |= homes(files)
    require_other((output,), taken)
    if is_dicom_name(output):
        require_dicom(series.sources, choices)
    elif is_image(output) and len(series) > 1:
        raise UserError(f"expected a folder, {MP4}, {WEBM} or .dcm for {len(series)} images, got {output}")
    if ending_of(output):
        codec_for(output)
    if (ending_of(output) or is_dicom_name(output)) and given.is_dir():
        common_size(path for path in series.sources if path.is_file() and path.suffix.lower() != ".npy")
    is_written = is_image(output) or is_dicom_name(output) or ending_of(output)
    # Of one file, letters alone are meant as a format; out.v1 and 2024.05.01 are folders.
    is_unknown = given.is_file() and output.suffix[1:].isalpha() and not is_written
    if (output.suffix.lower() in NOT_WRITTEN or is_unknown) and not output.is_dir():
        wanted = f"an image such as .png, .jpg or .tiff, a folder, {MP4}, {WEBM} or .dcm to write"
        raise UserError(f"expected {wanted}, got {output}")


def _watched(stage: str, names: Sequence[str], items: Stream) -> Stream:
    """The items, made in advance, with progress: reading, enhancing and writing overlap."""
    items = ahead(items)
    try:
        with progress(stage, len(names)) as report:
            for index, item in enumerate(items):
                yield item
                report(index + 1, names[index])
    finally:
        items.close()


def _say(notices: tuple[str, ...]) -> None:
    for notice in notices:
        sys.stderr.write(f"{notice}\n")


def _run_batch(flags: argparse.Namespace, setting: Setting) -> None:
    """Each input or what lies below it, into a folder. Raises UserError at the end where some have failed."""
    output: Path = flags.output
    is_file = is_image(output) or is_dicom_name(output) or output.suffix.lower() in VIDEOS | NOT_WRITTEN
    if is_file and not output.is_dir():
        raise UserError(f"expected a folder for the results of several inputs, got {output}")
    items = [_warned_item(item) for item in items_in(flags.inputs, output, below=flags.recursive)]
    if not any(item.is_video for item in items):
        _require_video(flags, "images, and there is no video among what was given")
    started = time.perf_counter()
    ended = list(_ended(items, setting, output))
    seconds = time.perf_counter() - started
    failed = [one for one in ended if "failure" in one]
    if flags.json:
        facts = provenance(**_shared(setting), items=ended, failed=len(failed), seconds=seconds)
        sys.stdout.write(strict_json(facts) + "\n")
    elif len(failed) < len(items):
        count = len(items) - len(failed)
        sys.stdout.write(f"{output}: {count} of {len(items)} enhanced in {seconds:.1f} s\n")
    images = [
        (f"{one['input']}/{image.name}", image.reason) for one in ended for image in one.get("failed", ())
    ]
    told = [(one["input"], one["failure"]) for one in failed]
    said = [f"{len(told)} of {len(items)} could not be enhanced: {_listed(told)}"] if told else []
    said += [f"{len(images)} of the images could not be read: {_listed(images)}"] if images else []
    if said:
        raise UserError("; ".join(said))


def _ended(items: list[Item], setting: Setting, output: Path) -> Iterator[dict[str, Any]]:
    """What became of each item, for the JSON; its notices are told at once."""
    for step in enhance_batch(items, setting, _watched):
        item, written = items[step.place - 1], step.written
        facts: dict[str, Any] = {"input": item.name, "output": item.output.relative_to(output).as_posix()}
        if step.failed is not None:
            yield facts | {"failure": step.failed.reason}
        elif written is not None:
            _say(tuple(f"{step.name}: {notice}" for notice in written.notices))
            facts |= {"pictures": written.pictures, "notices": written.notices}
            yield facts | ({"failed": written.failed} if written.failed else {})
