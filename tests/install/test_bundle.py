"""What a bundle leaves out, refuses and carries; and the desktop's files that ship with it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from configparser import ConfigParser
from importlib.metadata import distribution
from pathlib import Path
from xml.etree import ElementTree

import pytest

from app.gui.session_file import SUFFIX
from assets import guide_path, welcome_path
from install.bundle import left_out
from install.bundle.contents import BundleError, check, libraries
from install.bundle.licences import collect
from renderer.splat_files import SUFFIXES
from tests.app.conftest import ROOT

BUNDLE = ROOT / "install" / "bundle"
LINUX = BUNDLE / "linux"
NAMESPACE = "{http://www.freedesktop.org/standards/shared-mime-info}"
on_unix = pytest.mark.skipif(sys.platform == "win32", reason="a script of the shell")


def test_the_recipe_excludes_what_is_large_or_copyleft() -> None:
    assert {"torch", "gsplat", "av", "readline", "_gdbm"} <= set(left_out.EXCLUDED)
    spec = (BUNDLE / "vesselsplat.spec").read_text()
    compile(spec, "vesselsplat.spec", "exec")
    assert "excludes=list(EXCLUDED)" in spec
    overrides = (BUNDLE / "overrides.txt").read_text()
    assert {line.partition(" ")[0] for line in overrides.splitlines() if ";" in line} == {"torch", "av"}


def test_wheel_and_bundle_carry_the_guide_and_the_first_page() -> None:
    """Of the assets, the images of the README alone stay behind."""
    told = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert "assets" in told["packages"]
    spec = (BUNDLE / "vesselsplat.spec").read_text()
    assert 'excludes=["pictures/**", "**/__pycache__/**"]' in spec
    left = {file for pattern in told["exclude"] for file in ROOT.glob(f"{pattern}/**/*")}
    shipped = [*guide_path().iterdir(), *welcome_path().iterdir()]
    assert len(shipped) == 15
    assert not left & set(shipped)


@pytest.mark.parametrize("name", ["libx264-1a.so.164", "libx265.so.199", "libreadline.so.8", "libgdbm.so.6"])
def test_a_library_under_the_gpl_is_refused_by_its_name(tmp_path: Path, name: str) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / name).write_bytes(b"")
    with pytest.raises(BundleError, match=name.partition(".")[0]):
        check(tmp_path)


def test_an_ffmpeg_under_the_gpl_is_refused_by_its_own_words(tmp_path: Path) -> None:
    library = tmp_path / "libavcodec-0a1b.so.62.28"
    library.write_bytes(b"\x00--prefix=/ffmpeg_build --enable-libvpx --enable-shared\x00")
    check(tmp_path)
    library.write_bytes(b"\x00--prefix=/ffmpeg_build --enable-gpl --enable-libx264\x00")
    with pytest.raises(BundleError, match="--enable-gpl"):
        check(tmp_path)


def test_libraries_are_listed_with_what_they_were_taken_from(tmp_path: Path) -> None:
    import numpy

    core = next(Path(numpy.__file__).parent.rglob("_multiarray_umath*"))
    table = [
        ("numpy/_core/" + core.name, str(core), "EXTENSION"),
        ("own.so", str(tmp_path / "own.so"), "BINARY"),
        ("numpy/__init__.py", numpy.__file__, "DATA"),
    ]
    (tmp_path / "COLLECT-00.toc").write_text(repr((table,)))
    found = libraries(tmp_path / "COLLECT-00.toc")
    assert [(each.place, each.origin) for each in found] == [(table[0][0], "numpy"), ("own.so", "")]


def test_each_package_has_a_licence_in_the_folder(tmp_path: Path) -> None:
    names = ("numpy", "numba", "llvmlite", "pillow", "glfw", "moderngl", "matplotlib")
    told = collect(tmp_path, [distribution(name) for name in (*names, "pip")], [])
    folders = {path.name.partition(" ")[0].lower(): path for path in tmp_path.iterdir()}
    for name in (*names, "python"):
        texts = list(folders[name].iterdir())
        assert sum(text.stat().st_size for text in texts) > 500, name
    assert "numpy" not in told
    assert "pip" not in folders


def test_the_desktop_knows_the_files_that_the_window_opens() -> None:
    entry = ConfigParser(interpolation=None, delimiters=("=",))
    entry.optionxform = str  # type: ignore[assignment,method-assign]
    entry.read(LINUX / "vesselsplat.desktop", encoding="utf-8")
    told = entry["Desktop Entry"]
    types = set(told["MimeType"].strip(";").split(";"))
    assert told["Exec"].endswith("gui %F")
    own = ElementTree.parse(LINUX / "vesselsplat-mime.xml").getroot()
    defined = {
        kind.attrib["type"]: kind.find(f"{NAMESPACE}glob").attrib["pattern"]  # type: ignore[union-attr]
        for kind in own.iter(f"{NAMESPACE}mime-type")
    }
    assert set(defined) <= types
    assert set(defined.values()) == {f"*{suffix}" for suffix in (*SUFFIXES, SUFFIX)}
    assert {"image/png", "image/tiff", "video/mp4", "inode/directory"} <= types
    assert ElementTree.parse(LINUX / f"{told['Icon']}.svg").getroot().tag.endswith("svg")


@pytest.mark.skipif(shutil.which("desktop-file-validate") is None, reason="no desktop-file-validate here")
def test_the_desktop_entry_is_valid() -> None:
    done = subprocess.run(
        ["desktop-file-validate", LINUX / "vesselsplat.desktop"], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, "")


@on_unix
def test_the_entry_is_installed_with_its_whole_path_and_removed(tmp_path: Path) -> None:
    folder, data = tmp_path / "a folder of 100% $ap`p", tmp_path / "data"
    shutil.copytree(LINUX, folder)
    environment = os.environ | {"XDG_DATA_HOME": str(data)}
    subprocess.run([folder / "install-for-user"], check=True, env=environment)
    entry = (data / "applications" / "vesselsplat.desktop").read_text().splitlines()
    path = f"{folder}/vesselsplat".replace("$", "\\\\$").replace("`", "\\\\`").replace("%", "%%")
    assert f'Exec="{path}" gui %F' in entry
    assert (data / "icons/hicolor/scalable/apps/vesselsplat.svg").is_file()
    assert (data / "mime/packages/vesselsplat-mime.xml").is_file()
    subprocess.run([folder / "install-for-user", "--remove"], check=True, env=environment)
    left = [path.name for path in data.rglob("vesselsplat*")]
    assert left == []
