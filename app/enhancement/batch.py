"""Many images, folders and videos enhanced with the same settings, into a folder of the same structure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from app.enhancement.batch_names import FILM, STILL, alike, free_folder, free_name
from app.enhancement.enhance_files import Setting, Watch, Written, enhance_into, unwatched
from app.enhancement.kept_inputs import (
    files_of,
    homes,
    identities,
    require_other,
    require_outside,
    require_own,
)
from app.errors import UserError, sentence
from app.files.codecs import MP4
from app.files.image_files import is_still
from app.files.image_series import open_series
from app.files.stepping import map_steps
from enhance import ImageError
from renderer.clip import ClipError
from renderer.layouts import layout_of
from renderer.listing import listed
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_files.file_kinds import is_frame, is_visible, moves, natural_key
from renderer.readers.image_folders.picture_kinds import left_out, map_folders


@dataclass(frozen=True)
class Item:
    """One picture, one folder's pictures, or one video."""

    source: Path
    output: Path
    """A video, or the folder that pictures go into."""
    name: str
    """As a person reads it: the source below what was given."""
    notices: tuple[str, ...] = ()
    """What was passed over beside it."""
    called: str = ""
    """The name of a picture's output without suffix, where that of its file is taken; empty: as its file."""
    is_video: bool = False
    clip_options: ClipOptions | None = None
    """How it is read; None: as all."""

    @property
    def folder(self) -> Path:
        """Where its results lie."""
        return self.output.parent if self.is_video else self.output

    @property
    def files(self) -> tuple[Path, ...]:
        """Which may be written for a file; of a folder, the names of its pictures tell."""
        if self.is_video:
            return (self.output,)
        own = self.called or self.source.stem
        return () if self.source.is_dir() else tuple(self.output / f"{own}{ending}" for ending in STILL)


@dataclass(frozen=True)
class Failed:
    """An item of which nothing was written, or one image of it, with the reason in one line."""

    item: Item
    reason: str
    image: str = ""
    """Empty: all of the item."""

    @property
    def name(self) -> str:
        return f"{self.item.name}/{self.image}" if self.image else self.item.name


@dataclass(frozen=True)
class Step:
    """How far a batch has come."""

    place: int
    """Items that are done with."""
    count: int
    name: str
    """Of the item under way or just ended."""
    done: int = 0
    total: int = 0
    """Its pictures."""
    written: Written | None = None
    """What became of the item, at its end; None with `failed` set: nothing."""
    failed: Failed | None = None


def items_in(inputs: Sequence[Path], output: Path, *, below: bool) -> list[Item]:
    """What there is to enhance, in natural order; of a folder its pictures, or all that lies `below` it.

    One folder's structure is kept in `output` itself; of several inputs each has its own name there.

    Raises:
        UserError: nothing there, an output inside an input, which a second batch would take for one, or one
            that is a source itself, or a folder's in a folder that holds one, which it could overwrite.
    """
    for given in inputs:
        if not given.exists():
            raise UserError(f"expected an image, a folder or a video, got no such file: {given}")
    require_outside(output, [given for given in inputs if given.is_dir()])
    taken = set[str]()
    found, links, bare = list[Item](), list[str](), list[str]()
    for given in inputs:
        inside = list(_items_of(given, output, taken, links, alone=len(inputs) == 1, below=below))
        found += inside
        bare += [] if inside else [given.resolve().name]
    said = [_left_links(links)] if links else []
    if not found:
        names = ", ".join(bare)
        raise UserError("; ".join((f"expected images or videos, found none in {names}", *said)))
    said += [f"left out, nothing to enhance in {listed(bare)}"] if bare else []
    found[0] = replace(found[0], notices=(*found[0].notices, *said))
    read = [path for item in found for path in files_of(item.source)]
    require_other((item.output for item in found if item.source.is_dir()), homes(read))
    require_other((path for item in found for path in item.files), identities(read))
    return found


def _items_of(
    given: Path, output: Path, taken: set[str], links: list[str], *, alone: bool, below: bool
) -> Iterator[Item]:
    """With names that none of the outputs of other inputs have; `links` as of `_found`."""
    name = given.resolve().name
    if given.is_dir():
        target = output if alone else output / free_folder(name, taken)
        yield from _walk(given, target, name, links) if below else (Item(given, target, name),)
    elif is_still(given):
        own = free_name(given.stem, STILL, taken)
        yield Item(given, output, name, called="" if own == given.stem else own)
    else:
        yield Item(given, output / f"{free_name(given.stem, FILM, taken)}{MP4}", name, is_video=True)


def _walk(folder: Path, output: Path, name: str, links: list[str]) -> Iterator[Item]:
    """The folder's pictures, its videos, then the folders in it; a clip of many folders is one item, and so
    is a folder that cannot be read, of which `enhance_batch` says so."""
    try:
        yield from list(_found(folder, output, name, links))
    except OSError:
        yield Item(folder, output, name)


def _found(folder: Path, output: Path, name: str, links: list[str]) -> Iterator[Item]:
    """With notices of what is left out; `links` to folders are added where no item is there to tell of
    them."""
    if layout_of(folder).is_data_set:
        yield Item(folder, output, name)
        return
    maps = map_folders(folder)
    folders = [path for path in folder.iterdir() if path.is_dir() and is_visible(path) and path not in maps]
    linked = sorted(path.name for path in folders if path.is_symlink())
    found = list(_inside(folder, output, name, links))
    if not found:
        links += [f"{name}/{link}" for link in linked]
        for path in maps:
            yield from _walk(path, output / path.name, f"{name}/{path.name}", links)
        return
    said = [left_out(kind, [f"{path.name}/"]) for path, kind in maps.items()]
    if linked:
        said.append(_left_links(linked))
    yield replace(found[0], notices=(*said, *found[0].notices))
    yield from found[1:]


def _left_links(names: Sequence[str]) -> str:
    return f"left out, links to folders: {listed(names)}"


def _inside(folder: Path, output: Path, name: str, links: list[str]) -> Iterator[Item]:
    """What lies in a folder, but for the folders in it whose names say that they hold no frames."""
    inside = sorted((path for path in folder.iterdir() if not path.name.startswith(".")), key=natural_key)
    files = [path for path in inside if path.is_file()]
    videos = [path for path in files if moves(path)]
    if any(is_frame(path) or path.suffix.lower() == ".npy" for path in files):
        yield Item(folder, output, name)
    taken = {alike(f"{path.stem}{ending}") for path in files if path not in videos for ending in STILL}
    maps = map_folders(folder)
    folders = [path for path in inside if path.is_dir() and not path.is_symlink() and path not in maps]
    outputs = [output / free_folder(path.name, taken) for path in folders]
    stems = Counter(alike(path.stem) for path in videos)
    for path in videos:
        wanted = path.stem if stems[alike(path.stem)] == 1 else path.name
        own = free_name(wanted, FILM, taken)
        yield Item(path, output / f"{own}{MP4}", f"{name}/{path.name}", is_video=True)
    for path, place in zip(folders, outputs, strict=True):
        yield from _walk(path, place, f"{name}/{path.name}", links)


def enhance_batch(
    items: Sequence[Item], setting: Setting, watch: Watch = unwatched
) -> Generator[Step, None, None]:
    """All items one after another, each whole or not at all; one that fails is passed over.

    Closed before its end, it keeps the items that are whole and leaves nothing of the one under way.
    """
    apart = {item.source for item in items}
    for place, item in enumerate(items):
        try:
            yield Step(place, len(items), item.name)
            chosen = setting
            if item.is_video:
                require_own(item.output)
            if item.clip_options is not None:
                chosen = replace(setting, clip_options=item.clip_options)
            series = open_series(item.source, chosen.clip_options, apart)
            names = (item.called,) if item.called else series.names
            series = replace(series, names=names, notices=(*item.notices, *series.notices))
            step = partial(Step, place, len(items), item.name, total=len(series))
            written = yield from map_steps(enhance_into(item.output, series, chosen, watch), step)
        except (OSError, UserError, ClipError, ImageError, MemoryError) as error:
            failed = Failed(item, sentence(error))
            yield Step(place + 1, len(items), item.name, failed=failed)
        else:
            yield Step(place + 1, len(items), item.name, written=written)
