"""Clips without depth: a folder of pictures, or one picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from renderer.camera import Camera
from renderer.clip import Clip, ClipError
from renderer.listing import listed
from renderer.readers.clip_files import files_in
from renderer.readers.clip_options import FIELD_OF_VIEW
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.file_kinds import GIF, SUFFIXES, is_visible, moves, natural_key
from renderer.readers.image_files.pictures import common_size, read_rgb
from renderer.readers.image_files.used_bits import ALL, said_of_bits, used_bits
from renderer.readers.image_folders.pages import left_pages
from renderer.readers.image_folders.passed_over import broken_links, passed_over
from renderer.readers.image_folders.picture_kinds import PictureKinds, kinds_of
from renderer.readers.new_clip import new_clip
from renderer.readers.numbered_files import number_of

FEW = 3
"""So many times more numbered images make of the others a cover, a sketch, a logo."""


def open_images(path: Path, field_of_view: float = FIELD_OF_VIEW, bits: int | None = ALL) -> Clip:
    """The frames of a folder in natural order (2.jpg before 10.jpg); `bits` as of ClipOptions.

    Files that are no frames (`kinds_of`), and a few without a number beside numbered ones, are left
    out and reported, but for maps and masks, of which `with_maps` tells. Raises ClipError when there is
    none, when two have one name but for the suffix, or when sizes differ.
    """
    visible = [entry for entry in path.iterdir() if is_visible(entry)]
    files = sorted((entry for entry in visible if entry.is_file()), key=natural_key)
    kinds = kinds_of(files)
    paths = _frames_of(kinds)
    if not paths:
        raise ClipError(f"expected images in the folder, got none{_instead(visible, files)}: {path}")
    _check_names(paths, path)
    told = {*paths, *kinds.told}
    said = (*passed_over(files, told, "numbered images"), *broken_links(visible))
    camera = assumed_camera(field_of_view, common_size(paths))
    bits = bits or used_bits(paths)
    clip = new_clip(
        path,
        "images",
        cameras=(camera,) * len(paths),
        labels=tuple(entry.name for entry in paths),
        read_image=lambda index: read_rgb(paths[index], bits),
        notices=(*kinds.notices_of_pictures(), *said, *left_pages(paths), *said_of_bits(len(paths), bits)),
    )
    return replace(clip, bits=bits)


def _instead(visible: Sequence[Path], files: Sequence[Path]) -> str:
    """What a folder without images holds that can be opened, as the end of a sentence; empty for nothing."""
    # It loads numba, which whoever only reads images need not wait for.
    from renderer.splat_files import is_named_as_splats

    splats = [entry.name for entry in files if is_named_as_splats(entry)]
    if splats:
        own = "open one of these, or the run that they were exported from"
        return f"; it holds the splat files {listed(splats)}: {own}"
    folders = listed(sorted(entry.name for entry in visible if entry.is_dir()))
    videos = [entry.name for entry in files if moves(entry)]
    inside = f"folders {folders}" if folders else f"videos {listed(videos)}" if videos else ""
    return f"; it holds the {inside}: open one of these" if inside else ""


def frames_of(folder: Path) -> tuple[Path, ...]:
    """The pictures that `open_images` takes, in its order; none where there are none.

    Raises:
        ClipError: a picture that cannot be read.
    """
    return _frames_of(kinds_of(sorted(files_in(folder), key=natural_key)))


def _frames_of(kinds: PictureKinds) -> tuple[Path, ...]:
    """The numbered frames, where few others lie beside them; else all."""
    numbered = tuple(entry for entry in kinds.frames if number_of(entry) is not None)
    others = len(kinds.frames) - len(numbered)
    return numbered if FEW * others <= len(numbered) and numbered else kinds.frames


def _check_names(paths: tuple[Path, ...], folder: Path) -> None:
    """Raises ClipError for 1.jpg beside 1.png, which would be one moment twice."""
    first: dict[str, Path] = {}
    for path in paths:
        # What follows the last point of another name is a part of it, as of DICOM's numbers.
        name = path.stem if path.suffix.lower() in SUFFIXES | CODED | {GIF} else path.name
        other = first.setdefault(name, path)
        if other != path:
            both = f"{other.name} and {path.name}"
            raise ClipError(f"expected one image per name, got {both}; move one of them elsewhere: {folder}")


def open_image(path: Path, field_of_view: float = FIELD_OF_VIEW, bits: int | None = ALL) -> Clip:
    """One picture as a clip of one frame. Raises ClipError when it is none."""
    bits = bits or used_bits((path,))
    image = read_rgb(path, bits)
    clip = new_clip(
        path,
        "image",
        cameras=(assumed_camera(field_of_view, (image.shape[1], image.shape[0])),),
        labels=(path.name,),
        read_image=lambda index: read_rgb((path,)[index], bits),
        notices=(*left_pages((path,)), *said_of_bits(1, bits)),
    )
    return replace(clip, bits=bits)


def is_seen_by_assumption(clip: Clip) -> bool:
    """Its files state no calibration: its field of view is the one that was assumed."""
    return clip.format in ("images", "image", "video") and not clip.calibrated


def with_field_of_view(clip: Clip, degrees: float) -> Clip:
    """The clip through cameras of that horizontal field of view, where it is `is_seen_by_assumption`."""
    if not is_seen_by_assumption(clip) or not clip.has_one_size:
        return clip
    camera = assumed_camera(degrees, clip.size, clip.pixel_aspect)
    if camera == clip.cameras[0]:
        return clip
    return clip.through((camera,) * len(clip))


def assumed_camera(degrees: float, size: tuple[int, int], pixel_aspect: float = 1.0) -> Camera:
    """Of that horizontal field of view, for images of `size` (width, height) whose pixels are `pixel_aspect`
    times as wide as high."""
    camera = Camera.from_fov(degrees, *size)
    return replace(camera, fy=camera.fx * pixel_aspect)
