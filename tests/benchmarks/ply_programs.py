"""Which other programs read a splat file that `vesselsplat export --ply` wrote, for every degree.

python -m tests.benchmarks.ply_programs RUN|SPLATFILE [PYTHON]

PYTHON is an interpreter that has Open3D, PyMeshLab, plyfile and trimesh, which are none of this program's
dependencies; CloudCompare and splat-transform are looked for on the PATH. "first loader": what the loader of
the first 3D Gaussian Splatting viewer asserts, 45 fields f_rest_*.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from renderer.harmonics import BANDS
from renderer.ply_elements import read_ply

SECONDS: Final = 120.0
"""A program that takes longer is ended."""
OPEN3D: Final = (
    "import open3d as m, sys; print(m.__version__, len(m.io.read_point_cloud(sys.argv[1]).points))"
)
MESHLAB: Final = """import pymeshlab as m, sys
from importlib.metadata import version
meshes = m.MeshSet()
meshes.load_new_mesh(sys.argv[1])
print(version("pymeshlab"), meshes.current_mesh().vertex_number())"""
PLYFILE: Final = """import plyfile as m, sys
from importlib.metadata import version
print(version("plyfile"), m.PlyData.read(sys.argv[1])["vertex"].count)"""
TRIMESH: Final = "import trimesh as m, sys; print(m.__version__, len(m.load(sys.argv[1]).vertices))"
FIRST_LOADER: Final = """import plyfile as m, sys
from importlib.metadata import version
vertex = m.PlyData.read(sys.argv[1])["vertex"]
names = [one.name for one in vertex.properties]
for name in ("x", "y", "z", "opacity", "f_dc_0", "f_dc_1", "f_dc_2"):
    assert name in names
assert sum(name.startswith("f_rest_") for name in names) == 3 * (3 + 1) ** 2 - 3
assert sum(name.startswith("scale_") for name in names) == 3
assert sum(name.startswith("rot") for name in names) == 4
print(version("plyfile"), vertex.count)"""
PACKAGES: Final[Mapping[str, tuple[str, str]]] = {
    "Open3D": ("open3d", OPEN3D),
    "PyMeshLab": ("pymeshlab", MESHLAB),
    "plyfile": ("plyfile", PLYFILE),
    "trimesh": ("trimesh", TRIMESH),
    "first loader": ("plyfile", FIRST_LOADER),
}
"""By name: the package that it needs, and what prints its version and the points that it reads."""


@dataclass(frozen=True)
class Read:
    """What a program made of a file."""

    version: str
    points: int | None
    """None: it is not installed, or reads none."""
    word: str = ""
    """Why there are none."""

    def verdict(self, count: int) -> str:
        return self.word or ("read" if self.points == count else "LOSES SPLATS")


def main(scene: Path, python: str = sys.executable) -> None:
    print(f"{'program':<17}{'version':<17}{'degree':>6}{'splats':>9}{'read':>9}  verdict")
    with tempfile.TemporaryDirectory() as name:
        for degree in range(len(BANDS)):
            folder = Path(name) / str(degree)
            flags = ["--frames", "0", "--sh-degree", str(degree), "--ply", str(folder)]
            ran = run([sys.executable, "-m", "app", "export", str(scene), *flags])
            if ran.returncode:
                print(f"degree {degree}: {last_line(ran)}")
                continue
            (file,) = folder.glob("*.ply")
            count = len(read_ply(file.read_bytes()).elements[0].rows)
            for program, read in answers(file, python):
                points = "-" if read.points is None else str(read.points)
                line = (
                    f"{program:<17}{read.version:<17}{degree:>6}{count:>9}{points:>9}  {read.verdict(count)}"
                )
                print(line, flush=True)


def answers(file: Path, python: str) -> list[tuple[str, Read]]:
    found = [(name, of_package(python, *PACKAGES[name], file)) for name in PACKAGES]
    return [*found, ("CloudCompare", of_cloudcompare(file)), ("splat-transform", of_splat_transform(file))]


def of_package(python: str, package: str, code: str, file: Path) -> Read:
    if run([python, "-c", f"import importlib.util as u; assert u.find_spec({package!r})"]).returncode:
        return Read("-", None, "not installed")
    ran = run([python, "-c", code, str(file)])
    words = ran.stdout.split()
    if ran.returncode or len(words) < 2:
        return Read("-", None, f"FAILS: {last_line(ran)}")
    return Read(words[-2], int(words[-1]))


def of_cloudcompare(file: Path) -> Read:
    """The lines of the text file that it makes of the PLY file."""
    command = shutil.which("CloudCompare") or shutil.which("cloudcompare.CloudCompare")
    if command is None:
        return Read("-", None, "not installed")
    flags = ["-SILENT", "-O", str(file), "-C_EXPORT_FMT", "ASC", "-NO_TIMESTAMP", "-SAVE_CLOUDS"]
    ran, made = run([command, *flags]), file.with_suffix(".asc")
    if not made.exists():
        return Read("-", None, f"FAILS: {last_line(ran)}")
    return Read("-", len(made.read_text().splitlines()))


def of_splat_transform(file: Path) -> Read:
    """The splats of the PLY file that it makes of ours."""
    command = shutil.which("splat-transform")
    if command is None:
        return Read("-", None, "not installed")
    said, made = run([command, "--version"]), file.with_name("theirs.ply")
    ran = run([command, "--quiet", "--overwrite", str(file), str(made)])
    version = next(
        (word for word in (said.stdout + said.stderr).split() if word[:2].strip("v").isdigit()), "-"
    )
    if ran.returncode or not made.exists():
        return Read(version, None, f"FAILS: {last_line(ran)}")
    return Read(version, len(read_ply(made.read_bytes()).elements[0].rows))


def run(command: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 1, "", f"no answer in {SECONDS:.0f} s")


def last_line(ran: subprocess.CompletedProcess[str]) -> str:
    lines = (ran.stdout + ran.stderr).strip().splitlines()
    return lines[-1][:80] if lines else f"ended with {ran.returncode}"


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:3])
