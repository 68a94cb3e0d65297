"""The command line: which command is meant, its flags, and one line for a mistake.

Only the module of the chosen command is imported, so that `--help`, `--version` and `info` are quick.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, Protocol, cast

from app.errors import UserError

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

COMMANDS = {
    "gui": "open the app, on a clip, image, video or run when one is given",
    "demo": "built-in phantom clip: enhance, train, render, comparison sheet and report",
    "enhance": "enhance the vessels of an image, a folder of images or a video",
    "live": "a capture device or a stream, enhanced and recorded as it comes, with its delay measured",
    "tune": "try and measure a grid of settings on an image",
    "masks": "mask the tools in a clip, by their colour or as learned from masks of some frames",
    "train": "reconstruct a clip as dynamic 3D Gaussians",
    "render": "render the frames of a finished run, or a splat file",
    "export": "export a finished run as splat files, meshes, arrays, a video, a web page or poses",
    "evaluate": "measure a finished run on its held-out frames",
    "metrics": "measure DV/BV and contrast of images",
    "sweep": "every clip with every setting, measured, on this machine or a cluster; one table",
    "protocol": "the field's comparison of methods on clips, beside published figures",
    "report": "report of error against run time, contrast against noise, stability and omissions",
    "summary": "saved images with their measures and notes on one page to print",
    "replay": "reproduce an exported file from its provenance and compare",
    "phantom": "write a synthetic clip with exact ground truth",
    "prepare": "compile once what the first use of each feature would wait for; after installing",
    "info": "what a path is read as and what can be done with it; versions, devices and licences",
}


GENERAL = ("--help", "--version")
NAMED = r"-[^-=][^=]*\.[A-Za-z]\w*"
"""What looks like the name of a file, and not like a flag or a number."""
UNKNOWN = "unrecognized arguments: "
"""How argparse begins to say so."""


class Command(Protocol):
    """What each module of app.commands offers."""

    def add_flags(self, parser: argparse.ArgumentParser) -> None: ...

    def run(self, flags: argparse.Namespace) -> None: ...


class Parser(argparse.ArgumentParser):
    """argparse whose mistakes are one line, like every other mistake of the user."""

    def __init__(self, **words: Any) -> None:
        super().__init__(**words)
        # Also of a pair such as -1,5: what has a number's place is a value, not a flag.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        known = [name for action in self._actions for name in action.option_strings]
        flag = message.removeprefix(UNKNOWN).split()[0].split("=")[0] if message.startswith(UNKNOWN) else ""
        raise UserError(f"{message} ({_meant(flag, known)}see {self.prog} --help)")

    def print_help(self, file: SupportsWrite[str] | None = None) -> None:
        """Raises OSError, which argparse passes over: it cannot be printed, as on a full disk."""
        (file or sys.stdout).write(self.format_help())
        sys.stdout.flush()

    def require_once(self, arguments: Sequence[str]) -> None:
        """Raises UserError: a flag that takes one path is given twice."""
        given = [one.split("=")[0] for one in arguments]
        for action in self._actions:
            times = sum(given.count(name) for name in action.option_strings)
            if action.type is Path and isinstance(action, argparse._StoreAction) and times > 1:
                raise UserError(f"{action.option_strings[-1]}: expected it once, got it {times} times")


def run(arguments: Sequence[str]) -> None:
    """Do what the arguments ask.

    Raises:
        UserError: no such command, or flags that it does not have, or has once only.
        SystemExit: 0 after --help or --version.
    """
    if arguments and arguments[0] in ("-h", "--help"):
        sys.stdout.write(overview())
        return
    if arguments and arguments[0] == "--version":
        from app.files.provenance import NOTICE, version

        sys.stdout.write(f"VesselSplat {version()}\n{NOTICE}\n")
        return
    name, rest = chosen(arguments)
    command = load(name)
    parser = Parser(prog=f"vesselsplat {name}", description=COMMANDS[name], allow_abbrev=False)
    command.add_flags(parser)
    try:
        flags = parser.parse_args(rest)
    except UserError as error:
        raise UserError(f"{error}{_of_dashes(rest)}") from error
    parser.require_once(rest)
    command.run(flags)


def _of_dashes(arguments: Sequence[str]) -> str:
    """What to do about the first file that is taken for a flag, as the end of a sentence; else empty. One
    that is not there yet, as an output, is told by its suffix."""
    dashed = (one for one in arguments if one.startswith("-"))
    name = next((one for one in dashed if os.path.exists(one) or re.fullmatch(NAMED, one)), None)
    return "" if name is None else f" (a name that begins with a dash is given as {os.path.join('.', name)})"


def chosen(arguments: Sequence[str]) -> tuple[str, list[str]]:
    """Name of the command and its own arguments; without a command, or with a path, it is the app."""
    if not arguments:
        return "gui", []
    if "" in arguments:
        raise UserError(f"expected no empty name or value, got one as argument {arguments.index('') + 1}")
    if pipe := next((one for one in arguments if one == "-" or re.fullmatch("--[^=]+=-", one)), None):
        raise UserError(f"expected a file or folder, got {pipe}: pipes are not read")
    first, rest = arguments[0], list(arguments[1:])
    if first in COMMANDS:
        return first, rest
    if Path(first).exists() or len(Path(first).parts) > 1 or Path(first).suffix:
        return "gui", [first, *rest]
    if first.startswith("-"):
        nearest = _meant(first, GENERAL)
        raise UserError(f"expected a command before its flags, got {first} ({nearest}see vesselsplat --help)")
    wanted = f"expected a command ({', '.join(COMMANDS)}) or the path of a clip"
    nearest = _meant(first, tuple(COMMANDS)).rstrip()
    raise UserError(f"{wanted}, got {first!r}{f' ({nearest})' if nearest else ''}")


def _meant(word: str, known: Sequence[str]) -> str:
    """A question with the nearest of the known words; empty where none is near."""
    near = get_close_matches(word, known, n=1)
    return f"did you mean {near[0]}? " if near else ""


def load(name: str) -> Command:
    return cast(Command, import_module(f"app.commands.{name}"))


def overview() -> str:
    """The text of `vesselsplat --help`."""
    lines = "".join(f"  {name:<10}{text}\n" for name, text in COMMANDS.items())
    return (
        "usage: vesselsplat [COMMAND] [PATH] [flags]\n\n"
        "Makes blood vessels in endoscopic video visible, in 2D and in 3D.\n\n"
        f"{lines}\n"
        "vesselsplat COMMAND --help lists the flags of a command; --version prints the version.\n"
    )
