"""Completes what PyInstaller has made: licences, the list of its libraries, the desktop's files.

python -m install.bundle.finish FOLDER COLLECTED    COLLECTED is PyInstaller's COLLECT-00.toc
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from importlib.metadata import distributions
from pathlib import Path

from install.bundle.contents import BundleError, check, libraries
from install.bundle.licences import collect

HERE = Path(__file__).parent


def main(arguments: Sequence[str]) -> int:
    folder, collected = map(Path, arguments)
    try:
        finish(folder, collected)
    except BundleError as error:
        sys.stderr.write(f"bundle: {error}\n")
        return 2
    return 0


def finish(folder: Path, collected: Path) -> None:
    """Raises BundleError when it must not be given away."""
    check(folder)
    found = libraries(collected)
    from_system = {library.origin for library in found} & {
        path.name for path in Path("/usr/share/doc").glob("*")
    }
    collect(folder / "licenses", distributions(), from_system)
    lines = [f"{library.place}\t{library.origin or 'the system it was built on'}\n" for library in found]
    (folder / "licenses" / "libraries.txt").write_text("".join(lines), encoding="utf-8")
    if sys.platform.startswith("linux"):
        shutil.copytree(HERE / "linux", folder, dirs_exist_ok=True)
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    sys.stdout.write(
        f"{folder}: {size / 1e6:.0f} MB, {len(found)} libraries, listed in licenses/libraries.txt\n"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
