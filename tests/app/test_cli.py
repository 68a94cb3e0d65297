"""The command line: every mistake is one line and exit code 2, and leaves nothing behind."""

from __future__ import annotations

import errno
import inspect
import io
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.__main__ import main
from app.cli import COMMANDS, chosen, load
from app.errors import UserError
from tests.app.conftest import Cli

ROOT = Path(__file__).resolve().parents[2]


def picture(path: Path, seed: int = 0) -> Path:
    image = np.random.default_rng(seed).integers(0, 255, (24, 32, 3), dtype=np.uint8)
    assert cv2.imwrite(str(path), image)
    return path


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory, clip_path: Path) -> Path:
    """A folder with one of every bad input, which each mistake leaves as it is."""
    folder = tmp_path_factory.mktemp("bad")
    whole = picture(folder / "whole.png").read_bytes()
    picture(folder / "other.png", seed=1)
    (folder / "empty").mkdir()
    (folder / "truncated.png").write_bytes(whole[: len(whole) // 2])
    (folder / "text.mp4").write_text("no video at all\n")
    (folder / "text.png").write_text("no picture at all\n")
    np.save(folder / "nan.npy", np.full((8, 8, 3), np.nan, dtype=np.float32))
    np.save(folder / "large.npy", np.full((8, 8, 3), 7.0, dtype=np.float32))
    np.save(folder / "objects.npy", np.array([{"pickled": 1}], dtype=object))
    cv2.imwrite(str(folder / "deep.png"), np.full((8, 8, 3), 300, dtype=np.uint16))
    np.save(folder / "small.npy", np.zeros((4, 4, 3), dtype=np.float32))
    (folder / "mixed").mkdir()
    picture(folder / "mixed" / "0.png")
    (folder / "damaged").mkdir()
    for name in ("mixed", "damaged"):
        (folder / name / "1.png").write_bytes(whole[: len(whole) // 2])
    shutil.copytree(clip_path, folder / "fewer_depths")
    for path in (folder / "fewer_depths").glob("depth*/*000004*"):
        path.unlink()
    shutil.copytree(clip_path, folder / "inverted")
    for path in (*(folder / "inverted" / "masks").iterdir(), *(folder / "inverted").glob("gt_masks/*")):
        cv2.imwrite(str(path), 255 - cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
    shutil.copytree(clip_path, folder / "cut_frame")
    frame = sorted((folder / "cut_frame" / "images").iterdir())[4]
    frame.write_bytes(frame.read_bytes()[:500])
    (folder / "broken_run").mkdir()
    (folder / "broken_run" / "run.json").write_text('{"schema": 1, "version": 3')
    (folder / "foreign").mkdir()
    (folder / "foreign" / "thesis.txt").write_text("years of work")
    return folder


MISTAKES = [
    # (arguments, a word that the line must hold)
    (["bogus"], "expected a command"),
    (["enhence"], "did you mean enhance?"),
    (["--verison"], "did you mean --version?"),
    (["info", ""], "argument 2"),
    (["enhance", "{bad}/whole.png", "{out}.png", "--strenth", "2"], "did you mean --strength?"),
    (["train", "{clip}", "--run", "{out}", "--text-box", "10", "10", "5", "5"], "LEFT below RIGHT"),
    (["enhance"], "INPUT, OUTPUT"),
    (["enhance", "{bad}/nothing.png", "{out}"], "nothing.png"),
    (["enhance", "{bad}/nothing", "{out}"], "nothing"),
    (["enhance", "{bad}/empty", "{out}"], "empty"),
    (["enhance", "{bad}/truncated.png", "{out}.png"], "truncated.png"),
    (["enhance", "{bad}/text.png", "{out}.png"], "text.png"),
    (["enhance", "{bad}/text.mp4", "{out}.mp4"], "text.mp4"),
    (["enhance", "{bad}/nan.npy", "{out}.npy"], "NaN"),
    (["enhance", "{bad}/large.npy", "{out}.npy"], "[0, 1]"),
    (["enhance", "{bad}/objects.npy", "{out}.npy"], "objects.npy"),
    (["enhance", "{bad}/damaged", "{out}"], "1.png"),
    (["enhance", "{bad}/damaged", "{out}", "--statistics", "clip"], "1.png"),
    (["enhance", "{bad}/mixed", "{bad}/mixed"], "never overwritten"),
    (["enhance", "{bad}/whole.png", "{bad}/whole.png"], "never overwritten"),
    (["enhance", "{bad}/whole.png", "{bad}"], "never overwritten"),
    (["enhance", "{bad}/whole.png", "{out}.avi"], "out.avi"),
    (["enhance", "{bad}/whole.png", "{out}.gif"], "out.gif"),
    (["enhance", "{bad}/mixed", "{out}.png"], "2 images"),
    (["enhance", "{bad}/small.npy", "{out}.png"], ".png cannot hold float32"),
    (["enhance", "{bad}/deep.png", "{out}.jpg"], "name the output .png, .tiff or .npy"),
    (["enhance", "{bad}/small.npy", "{out}.dcm"], "not float32; name the output .tiff or .npy"),
    (["enhance", "{bad}/small.npy", "{out}.mp4"], "8-bit"),
    (["enhance", "{bad}/whole.png", "{out}.png", "--z", "7"], "--z"),
    (["enhance", "{bad}/whole.png", "{out}.png", "--z", "nan"], "--z"),
    (["enhance", "{bad}/whole.png", "{out}.png", "--radii", "4", "x"], "--radii"),
    (["enhance", "{bad}/whole.png", "{out}.png", "--p", "1", "2"], ": expected one p, or one for each of 3"),
    (["enhance", "{bad}/whole.png", "{out}.png", "--statistics", "none"], "--statistics"),
    (["enhance", "{bad}/whole.png", "{bad}/text.mp4/out.png"], "a file as a parent"),
    (["train", "{bad}/nothing", "--run", "{out}"], "nothing"),
    (["train", "{bad}/empty", "--run", "{out}"], "empty"),
    (["train", "{bad}/text.mp4", "--run", "{out}"], "text.mp4"),
    (["train", "{bad}/fewer_depths", "--run", "{out}"], "depth"),
    (["train", "{bad}/inverted", "--run", "{out}"], "mask"),
    (["train", "{bad}/cut_frame", "--run", "{out}"], "truncated"),
    (["train", "{bad}/cut_frame", "--run", "{out}", "--input", "enhanced"], "truncated"),
    (["train", "{bad}/whole.png", "--run", "{out}"], "depth"),
    (["train", "{clip}", "--run", "{bad}/foreign"], "other files"),
    (["train", "{clip}", "--run", "{bad}/foreign", "--resume"], "run.json"),
    (["train", "{clip}", "--run", "{out}", "--resume"], "run.json"),
    (["train", "{clip}", "--run", "{bad}/whole.png"], "got a file"),
    (["train", "{clip}"], "--run"),
    (["train", "{clip}", "--run", "{out}", "--iterations", "0"], "--iterations"),
    (["train", "{clip}", "--run", "{out}", "--method", "magic"], "--method"),
    (["train", "{clip}", "--run", "{out}", "--device", "cuda"], "cuda"),
    (["train", "{clip}", "--run", "{out}", "--sh-degree", "4"], "--sh-degree"),
    (["train", "{clip}", "--run", "{out}", "--keep", "harmonics", "hair"], "--keep"),
    (["train", "{clip}", "--run", "{out}", "--keep", "deformation", "--leave-out", "deformation"], "both"),
    (["evaluate", "{bad}/nothing"], "run.json"),
    (["evaluate", "{bad}/empty"], "run.json"),
    (["evaluate", "{bad}/broken_run"], "run.json"),
    (["render", "{bad}/empty", "--out", "{out}"], "run.json"),
    (["render", "{bad}/some.ply", "--out", "{out}"], "expected a splat file"),
    (["tune", "{bad}/whole.png", "--vary", "z=0:1:401", "--out", "{out}"], "COUNT from 1 to 400"),
    (["metrics", "{bad}/nothing.png"], "nothing.png"),
    (["metrics", "{bad}/nan.npy"], "NaN"),
    (["metrics", "{bad}/whole.png", "--against", "{bad}/nan.npy"], "NaN"),
    (["metrics", "{bad}/whole.png", "--against", "{bad}/small.npy"], "32x24"),
    (["metrics", "{bad}/whole.png", "{bad}/other.png", "--against", "{bad}/whole.png"], "one original"),
    (["phantom", "{bad}/foreign"], "foreign"),
    (["phantom", "{out}", "--frames", "0"], "--frames"),
    (["phantom", "{out}", "--size", "1", "1"], "--size"),
    (["phantom", "{out}", "--camera", "shaky"], "--camera"),
    (["demo", "--out", "{bad}/whole.png"], "whole.png"),
    (["{bad}/nothing.mp4"], "nothing.mp4"),
]


def files_of(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else b""
        for path in folder.rglob("*")
    }


@pytest.mark.parametrize(("arguments", "word"), MISTAKES, ids=str)
def test_a_mistake_is_one_line_and_changes_nothing(
    bad: Path, clip_path: Path, vesselsplat: Cli, arguments: list[str], word: str
) -> None:
    before = files_of(bad)
    filled = [text.format(bad=bad, out=bad / "out", clip=clip_path) for text in arguments]
    call = vesselsplat(*filled)
    assert call.code == 2
    assert call.out == ""
    assert call.error.startswith("vesselsplat: ")
    assert call.error.count("\n") == 1
    assert "Traceback" not in call.error
    assert word in call.error
    assert files_of(bad) == before


def test_links_that_lead_to_each_other_are_told(bad: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "one").symlink_to("other")
    (tmp_path / "other").symlink_to("one")
    call = vesselsplat("tune", bad / "whole.png", "--vary", "z=0,1", "--out", tmp_path / "one")
    *_, last = call.error.splitlines()  # From Python 3.13 on, after what comes before it is written.
    assert (call.code, last.startswith("vesselsplat: "), str(tmp_path / "one") in last) == (2, True, True)


def test_every_command_has_its_module() -> None:
    for name in COMMANDS:
        command = load(name)
        assert list(inspect.signature(command.add_flags).parameters) == ["parser"]
        assert list(inspect.signature(command.run).parameters) == ["flags"]


@pytest.mark.parametrize("name", list(COMMANDS))
def test_help_of_a_command_ends_well(name: str, vesselsplat: Cli) -> None:
    with pytest.raises(SystemExit) as ended:
        vesselsplat(name, "--help")
    assert ended.value.code == 0


def test_what_is_no_command_but_a_path_opens_the_app(tmp_path: Path) -> None:
    assert chosen([]) == ("gui", [])
    assert chosen([str(tmp_path)]) == ("gui", [str(tmp_path)])
    assert chosen(["clip.mp4"]) == ("gui", ["clip.mp4"])
    assert chosen(["train", "clip"]) == ("train", ["clip"])
    with pytest.raises(UserError, match="expected a command"):
        chosen(["tarin"])


def test_version_carries_the_notice(vesselsplat: Cli) -> None:
    call = vesselsplat("--version")
    assert call.code == 0
    assert call.out.endswith("Research use only. Not a medical device.\n")


def test_info_is_one_json_object_without_paths(vesselsplat: Cli) -> None:
    call = vesselsplat("info", "--json")
    facts = json.loads(call.out)
    assert facts["packages"]["numpy"] == np.__version__
    assert facts["cuda_devices"] >= 0
    assert str(Path.home()) not in call.out
    assert str(ROOT) not in call.out


def test_help_says_auto_for_what_is_automatic(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("enhance", "train"):
        with pytest.raises(SystemExit):
            main([name, "--help"])
        said = capsys.readouterr().out
        assert "auto" in said.lower()
        assert "none" not in said.lower()


def test_a_bug_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch, vesselsplat: Cli) -> None:
    monkeypatch.setattr("app.commands.info.collect", lambda: [][0])
    with pytest.raises(IndexError):
        vesselsplat("info")


def test_too_little_memory_is_one_line(monkeypatch: pytest.MonkeyPatch, vesselsplat: Cli) -> None:
    def starved() -> None:
        raise MemoryError

    monkeypatch.setattr("app.commands.info.collect", starved)
    call = vesselsplat("info")
    assert (call.code, call.error.count("\n"), "out of memory" in call.error) == (2, 1, True)


def test_no_place_for_compiled_kernels_is_one_line(tmp_path: Path) -> None:
    # Neither the program's folder nor that of the user, as for a stranger in a container.
    environment = os.environ | {"NUMBA_CACHE_LOCATOR_CLASSES": "ZipCacheLocator"}
    command = [sys.executable, "-m", "app", "enhance", picture(tmp_path / "a.png"), tmp_path / "b.png"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=environment)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "NUMBA_CACHE_DIR" in done.stderr


def test_an_interruption_is_one_line_and_130(monkeypatch: pytest.MonkeyPatch, vesselsplat: Cli) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("app.commands.info.collect", interrupted)
    call = vesselsplat("info")
    assert (call.code, call.error) == (130, "vesselsplat: interrupted\n")


@pytest.mark.parametrize("arguments", ["--help", "metrics {picture}", "metrics {picture} --json"])
def test_a_reader_that_leaves_is_no_error(tmp_path: Path, arguments: str) -> None:
    given = arguments.format(picture=picture(tmp_path / "whole.png"))
    shell = f"'{sys.executable}' -m app {given} | true; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(("system", "code"), [("win32", 0), ("linux", 2)])
def test_nor_is_it_where_systems_say_it_as_windows_does(
    monkeypatch: pytest.MonkeyPatch, system: str, code: int
) -> None:
    class Left(io.StringIO):
        def write(self, text: str, /) -> int:
            raise OSError(errno.EINVAL, "Invalid argument")

        def fileno(self) -> int:
            return writer

    reader, writer = os.pipe()
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(sys, "stdout", Left())
    assert main(["--version"]) == code
    for end in (reader, writer):
        os.close(end)


def test_what_is_no_terminals_is_utf8_whatever_the_system_writes(tmp_path: Path) -> None:
    path = picture(tmp_path / "M\xfcller-\u80c3.png")
    environment = os.environ | {"PYTHONIOENCODING": "cp1252"}
    command = [sys.executable, "-m", "app", "info", str(path)]
    for more in ((), ("--json",)):
        done = subprocess.run([*command, *more], capture_output=True, cwd=ROOT, env=environment, check=True)
        assert path.name in done.stdout.decode("utf-8")
        assert not more or json.loads(done.stdout)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no device that is full")
@pytest.mark.parametrize("arguments", [("info",), ("--help",), ("train", "--help"), ("info", "--help")])
def test_a_full_place_of_what_is_printed_is_named(arguments: tuple[str, ...]) -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([sys.executable, "-m", "app", *arguments], cwd=ROOT, stdout=full, stderr=-1)
    assert done.returncode == 2
    assert done.stderr.decode() == "vesselsplat: No space left on device: standard output\n"


@pytest.mark.skipif(sys.platform == "win32", reason="no folder is removed there while it is anyone's own")
def test_a_current_folder_that_is_gone_is_named(
    vesselsplat: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    called = vesselsplat("enhance", "a.png", "b.png")
    assert called.code == 2
    called = vesselsplat("protocol", "a", "--out", "b")
    assert (called.code, called.error) == (2, "vesselsplat: No such file or directory: the current folder\n")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("enhance", "-", "out.png"), "expected a file or folder, got -: pipes are not read"),
        (("enhance", "in.png", "-"), "got -: pipes are not read"),
        (("train", "clip", "--run=-"), "got --run=-: pipes are not read"),
        (("export", "run", "--ply", "a", "--ply", "b"), "--ply: expected it once, got it 2 times"),
        (("export", "run", "--html=a.html", "--html", "b.html"), "--html: expected it once, got it 2 times"),
    ],
)
def test_a_path_is_no_pipe_and_given_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vesselsplat: Cli, arguments: tuple[str, ...], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    call = vesselsplat(*arguments)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert said in call.error
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_streams_that_are_closed_are_no_error(closed: str) -> None:
    shell = f"'{sys.executable}' -m app --version {closed}"
    done = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("minutes", ["nan", "0", "-1", "inf", "soon"])
def test_a_time_that_is_none_is_refused(minutes: str, tmp_path: Path, vesselsplat: Cli) -> None:
    call = vesselsplat("report", "--out", tmp_path / "report", "--minutes", minutes)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert f"expected a number above 0, got '{minutes}'" in call.error
    assert not (tmp_path / "report").exists()


def test_a_circle_without_inside_is_refused(tmp_path: Path, vesselsplat: Cli) -> None:
    call = vesselsplat("train", ROOT, "--run", tmp_path / "run", "--view-circle", "0", "0", "-5")
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "--view-circle" in call.error


@pytest.mark.parametrize(
    ("module", "absent"),
    [
        ("app.__main__", ("torch", "numba", "cv2", "numpy", "imgui_bundle")),
        ("app.commands.info", ("torch", "numba", "imgui_bundle")),
        ("app.runs.job", ("torch", "imgui_bundle", "moderngl")),
    ],
)
def test_light_modules_stay_light(module: str, absent: tuple[str, ...]) -> None:
    script = f"import sys, {module}; print([name for name in {absent!r} if name in sys.modules])"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment)
    assert (done.stdout, done.stderr) == ("[]\n", "")


@pytest.mark.parametrize("arguments", [["info", "-dash.png"], ["enhance", "-dash.png", "out"], ["-dash.png"]])
def test_a_file_that_is_taken_for_a_flag(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vesselsplat: Cli, arguments: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    hint = f" (a name that begins with a dash is given as {os.path.join('.', '-dash.png')})\n"
    for _ in range(2):  # Before it is there, as of an output, and after.
        refused = vesselsplat(*arguments)
        assert (refused.code, refused.error.endswith(hint)) == (2, True)
        picture(tmp_path / "-dash.png")


@pytest.mark.parametrize("flag", ["-d", "-1.5", "--z.auto", "-z=0.5"])
def test_what_is_no_name_of_a_file_is_not_taken_for_one(vesselsplat: Cli, flag: str) -> None:
    refused = vesselsplat("enhance", flag, "out")
    assert (refused.code, "begins with a dash" in refused.error) == (2, False)
