"""Images of a folder that are no recording: each of a size of its own, looked at one after the other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from renderer.clip import Clip, ClipError
from renderer.listing import listed
from renderer.readers.clip_files import files_in
from renderer.readers.clip_options import FIELD_OF_VIEW
from renderer.readers.image_files.file_kinds import is_visible, natural_key
from renderer.readers.image_files.pictures import read_rgb, upright_size
from renderer.readers.image_files.used_bits import ALL, said_of_bits, used_bits
from renderer.readers.image_folders.frames import assumed_camera
from renderer.readers.image_folders.passed_over import NOT_READABLE, broken_links, passed_over
from renderer.readers.image_folders.picture_kinds import kinds_of
from renderer.readers.new_clip import new_clip

NOT_ONE_SIZE = "the images differ in size, so they are no recording to reconstruct"


def images_in(folder: Path) -> tuple[Path, ...]:
    """In natural order; maps and masks beside them are none. Raises OSError."""
    return kinds_of(_files(folder)).frames


def _files(folder: Path) -> list[Path]:
    return sorted(filter(is_visible, files_in(folder)), key=natural_key)


def open_stills(path: Path, field_of_view: float = FIELD_OF_VIEW, bits: int | None = ALL) -> Clip:
    """The images of a folder, whatever their sizes; those that cannot be read are passed over and named.
    `bits` as of ClipOptions.

    Raises ClipError: none can be read.
    """
    files, sizes, unreadable = _files(path), dict[Path, tuple[int, int]](), list[str]()
    kinds = kinds_of(files)
    for image in kinds.frames:
        try:
            sizes[image] = upright_size(image)
        except ClipError:
            unreadable.append(image.name)
    if not sizes:
        raise ClipError(f"expected images in the folder, got none that can be read: {path}")
    images = tuple(sizes)
    bits = bits or used_bits(images)
    clip = new_clip(
        path,
        "images",
        cameras=tuple(assumed_camera(field_of_view, size) for size in sizes.values()),
        labels=tuple(image.name for image in images),
        read_image=lambda index: read_rgb(images[index], bits),
        notices=(
            *kinds.notices(),
            *((f"{NOT_READABLE}: {listed(unreadable)}",) if unreadable else ()),
            *passed_over(files, {*kinds.frames, *kinds.told}),
            *broken_links(path.iterdir()),
            *said_of_bits(len(images), bits),
        ),
    )
    return replace(clip, why_no_depth=NOT_ONE_SIZE)
