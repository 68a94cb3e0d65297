"""`vesselsplat info PATH` tells what a path is read as, what is missing and what to do; it writes nothing."""

from __future__ import annotations

import json
import shlex
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image

from app.files.image_files import write_image
from app.files.provenance import provenance
from app.gui.session_file import Session, SessionSource, write_session
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from tests.app.conftest import CONFIG, Cli, request_of, tissue
from tests.renderer.eyes import look, write_eyes
from tests.renderer.readers.numbered import encoded, numbered_picture

Told = Callable[[Path], dict[str, Any]]


@pytest.fixture
def told(vesselsplat: Cli) -> Told:
    """What is told of a path as JSON, after a look at the text."""

    def tell(path: Path) -> dict[str, Any]:
        before = sorted((entry, entry.stat().st_mtime_ns) for entry in path.parent.rglob("*"))
        text, values = vesselsplat("info", path), vesselsplat("info", path, "--json")
        assert (text.code, text.error, values.code, values.error) == (0, "", 0, "")
        assert all(line[12] == " " and line[13] != " " for line in text.out.splitlines())
        assert sorted((entry, entry.stat().st_mtime_ns) for entry in path.parent.rglob("*")) == before
        facts: dict[str, Any] = json.loads(values.out)
        assert [name.replace(" ", "_") for name in _names(text.out)] == list(facts)
        return facts

    return tell


def _names(text: str) -> list[str]:
    return [line[:13].strip() for line in text.splitlines() if line[:13].strip()]


def test_a_clip_with_everything(clip_path: Path, told: Told) -> None:
    facts = told(clip_path)
    assert facts["what"] == {"layout": "endonerf", "stereo": False}
    assert facts["frames"] == {"count": 10, "first": 0, "last": 9, "step": 1, "missing": []}
    assert facts["size"] == [64, 48]
    assert facts["depth"]["origin"] == "measured"
    assert 0.5 < facts["depth"]["share"] <= 1
    assert 0.5 < facts["masks"]["tissue_share"] < 1
    assert facts["camera"]["fixed"]
    assert (facts["unit"], facts["held_out"], facts["missing"]) == ("mm", 2, [])
    assert facts["next"] == [
        f"vesselsplat enhance {clip_path} OUT",
        f"vesselsplat train {clip_path} --run RUN",
    ]


def test_a_camera_that_moves(tmp_path: Path, told: Told) -> None:
    write_phantom(
        tmp_path / "clip", PhantomParams(n_frames=4, width=48, height=32, seed=1, camera="moving"), "scared"
    )
    facts = told(tmp_path / "clip")
    assert facts["what"]["layout"] == "scared"
    assert not facts["camera"]["fixed"]
    assert facts["camera"]["way"] > 0


def test_pictures_lack_depth_and_some_numbers(folder: Path, vesselsplat: Cli, told: Told) -> None:
    for number in (7, 8, 12):
        cv2.imwrite(str(folder / f"{number}.png"), tissue(number))
    cv2.imwrite(str(folder / "2_mask.png"), tissue(1))
    facts = told(folder)
    assert facts["frames"]["missing"] == [3, 4, 5, 6, 9, 10, 11]
    assert "missing 7: 3 to 6, 9 to 11" in vesselsplat("info", folder).out
    assert facts["depth"]["origin"] is None
    assert "depth" in facts["missing"]
    assert "2_mask.png" in facts["notices"][0]
    assert facts["camera"]["assumed"]
    assert facts["lens"] == {"distortion": None}
    assert facts["next"][1].endswith("--depth brightness")


def test_every_other_frame_is_not_missing(tmp_path: Path, told: Told) -> None:
    path = tmp_path / "in"
    path.mkdir()
    for number in range(0, 40, 10):
        cv2.imwrite(str(path / f"{number}.png"), tissue(number))
    facts = told(path)
    assert (facts["frames"]["step"], facts["frames"]["missing"]) == (10, [])


def test_a_date_among_numbers_is_told_at_once(folder: Path, told: Told) -> None:
    cv2.imwrite(str(folder / "20231128123456789.png"), tissue(3))
    frames = told(folder)["frames"]
    assert (frames["count"], frames["last"], frames["missing"]) == (4, 20231128123456789, None)


def test_pairs_that_match_and_pairs_that_do_not(tmp_path: Path, told: Told) -> None:
    path = tmp_path / "clip"
    write_eyes(
        path, "left/{:06d}.png", "right/{:06d}.png", count=2, width=192, height=144, seed=41, noise=0.5
    )
    facts = told(path)
    assert facts["what"]["stereo"]
    assert facts["depth"]["origin"] == "stereo"
    assert any("--baseline" in each for each in facts["missing"])
    assert facts["next"][0] == f"vesselsplat enhance {path / 'left'} OUT"
    for eye in (path / "right").iterdir():
        seen = cv2.imread(str(eye))
        turn = cv2.getRotationMatrix2D((96, 72), 4, 1)
        cv2.imwrite(str(eye), cv2.warpAffine(seen, turn, (192, 144)))
    facts = told(path)
    assert facts["what"]["stereo"]
    assert "rows at most 1.5 px apart" in facts["depth"]["why"]
    assert facts["next"][1].endswith("--depth brightness")


def test_the_commands_that_come_next_work(
    clip_path: Path, folder: Path, tmp_path: Path, vesselsplat: Cli, told: Told
) -> None:
    odd = tmp_path / "Jürgen Groß (3)"
    folder.rename(odd)
    for path in (clip_path, odd):
        for number, line in enumerate(told(path)["next"]):
            place = str(tmp_path / f"{path.name}-{number}")
            words = [place if word in ("OUT", "RUN") else word for word in shlex.split(line)]
            extra = ("--iterations", 2) if words[1] == "train" else ()
            assert vesselsplat(*words[1:], *extra).code == 0


def test_a_video_by_its_header(tmp_path: Path, vesselsplat: Cli) -> None:
    path = tmp_path / "v.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for index in range(5):
        writer.write(cv2.resize(tissue(index), (64, 48)))
    writer.release()
    facts = json.loads(vesselsplat("info", path, "--json").out)
    assert facts["frames"] == {"count": 5}
    assert facts["frame_rate"] == {"frames_per_second": 10.0, "steady": True}
    assert facts["size"] == [64, 48]
    assert facts["next"][0] == f"vesselsplat enhance {path} OUT.mp4"
    assert facts["lens"] == {"distortion": None}
    said = "treated as free of distortion: of a camera that moves --depth motion finds it"
    assert f"lens         {said}, --calibration gives it\n" in vesselsplat("info", path).out


def test_a_video_has_the_rate_and_the_frames_that_the_window_tells(tmp_path: Path, vesselsplat: Cli) -> None:
    times = [0.0, 0.1, 0.14, 0.18, 0.5, 1.3, 1.34, 1.7]
    path = encoded(tmp_path / "varies.mp4", [numbered_picture(number) for number in range(8)], times=times)
    facts = json.loads(vesselsplat("info", path, "--json").out)
    clip = open_clip(path)
    assert facts["frames"] == {"count": len(clip)}
    assert facts["frame_rate"] == {"frames_per_second": clip.frames_per_second, "steady": False}
    said = vesselsplat("info", path).out
    assert "frame rate   varies, 4.118 a second on average\n" in said
    assert "frames       8, " in said


def test_of_a_video_whose_halves_look_alike_it_is_said_as_the_window_says_it(
    tmp_path: Path, vesselsplat: Cli
) -> None:
    pair = look(0, width=128, height=96, seed=41, noise=0.5, n_frames=1)
    both = np.concatenate((pair.left.image, pair.right.image), axis=1)
    alike, other = encoded(tmp_path / "a.mp4", 3 * [both]), encoded(tmp_path / "b.mp4", 3 * [pair.left.image])
    (said,) = open_clip(alike).notices
    assert "look alike" in said
    facts = json.loads(vesselsplat("info", alike, "--json").out)
    assert facts["notices"] == [said]
    of_one, of_two = facts["next"][:3], facts["next"][3:]
    assert of_one == json.loads(vesselsplat("info", other, "--json").out.replace("b.mp4", "a.mp4"))["next"]
    assert [step.split()[-2:] for step in of_two] == 2 * [["--stereo", "side-by-side"]]
    assert "notices" not in json.loads(vesselsplat("info", other, "--json").out)


def test_of_a_video_that_is_cut_off_the_notice_is_that_of_other_commands(tmp_path: Path, told: Told) -> None:
    path = encoded(tmp_path / "v.avi", [numbered_picture(number) for number in range(90)])
    assert "notices" not in told(path)
    content = path.read_bytes()
    path.write_bytes(content[: int(0.6 * len(content))])
    clip, facts = open_clip(path), told(path)
    assert clip.notices[0].startswith("the file is cut off or damaged at its end: ")
    assert (facts["notices"], facts["frames"]) == ([clip.notices[0]], {"count": len(clip)})


def test_floats_are_told_with_their_range(tmp_path: Path, told: Told) -> None:
    values = np.linspace(0.25, 0.75, 20 * 30 * 3, dtype=np.float32).reshape(20, 30, 3)
    write_image(tmp_path / "own.tiff", values, {})
    assert told(tmp_path / "own.tiff")["size"] == [30, 20, 3]
    np.save(tmp_path / "far.npy", 7 * values.reshape(20, 90))
    facts = told(tmp_path / "far.npy")
    assert facts["what"] == {"kind": "values"}
    assert (facts["size"], facts["values"]) == ([90, 20, 1], [1.75, 5.25])
    assert "next" not in facts
    assert cv2.imwrite(str(tmp_path / "a.tif"), values)
    facts = told(tmp_path / "a.tif")
    assert (facts["size"], facts["values"]) == ([30, 20, 3], [0.25, 0.75])
    assert facts["next"] == [f"vesselsplat enhance {tmp_path / 'a.tif'} OUT.tiff"]


@pytest.mark.parametrize(
    ("form", "name", "format"),
    [
        ("splatting", "cameras.json", "cameras.json of 3D Gaussian Splatting"),
        ("transforms", "transforms.json", "transforms.json of NeRF"),
        ("colmap", "sparse", "text model of COLMAP"),
    ],
)
def test_cameras_are_told(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, told: Told,
    form: str, name: str, format: str,
) -> None:  # fmt: skip
    path = tmp_path / name
    flags = ("--cameras", path, "--cameras-format", form, "--frames", 2, 5)
    assert vesselsplat("export", runs["original"], *flags).code == 0
    facts = told(path)
    assert facts["what"] == {"kind": "cameras", "format": format}
    assert (facts["cameras"], facts["size"]) == ({"count": 2}, [[64, 48]])
    assert "2 cameras, frame-000002 to frame-000005" in vesselsplat("info", path).out
    assert facts["next"] == [f"vesselsplat render RUN --camera {path} --time 0 --out OUT"]


def test_a_description_of_a_sweep_and_its_table(
    folder: Path, tmp_path: Path, vesselsplat: Cli, told: Told
) -> None:
    spec = tmp_path / "spec.toml"
    lines = (f'clips = ["{folder}"]', 'task = "enhance"', "frames = 1", "[grid]", "d_factor = [0.5, 1.0]")
    spec.write_text("\n".join(lines))
    facts = told(spec)
    assert facts["what"] == {"kind": "sweep description", "task": "enhance"}
    assert (facts["clips"], facts["jobs"], facts["varied"]) == ({"count": 1}, {"count": 2}, ["d_factor"])
    table = tmp_path / "table.csv"
    table.write_text("job,clip,state,reason,d_factor\na,b,finished,,1\nc,b,failed,why,2\n")
    facts = told(table)
    assert facts["what"] == {"kind": "sweep table"}
    assert facts["jobs"] == {"finished": 1, "failed": 1}
    assert facts["columns"] == ["job", "clip", "state", "reason", "d_factor"]
    for name, content in (("a.toml", "task = 3"), ("a.csv", "x,y\n1,2\n"), ("b.csv", "\xff\0")):
        (tmp_path / name).write_text(content, encoding="latin-1")
        call = vesselsplat("info", tmp_path / name)
        assert (call.code, call.error.count("\n")) == (2, 1)


def test_an_image_that_a_decoder_of_videos_reads(tmp_path: Path, told: Told) -> None:
    path = tmp_path / "still.avif"
    Image.fromarray(tissue(1)).save(path)
    facts = told(path)
    assert (facts["what"]["layout"], facts["next"][0]) == ("image", f"vesselsplat enhance {path} OUT.png")


def test_a_finished_run_and_one_that_was_cut_short(
    runs: dict[str, Path], clip_path: Path, tmp_path: Path, told: Told
) -> None:
    facts = told(runs["enhanced"])
    assert facts["what"] == {"kind": "run", "state": "finished"}
    assert facts["clip"] == {"path": str(clip_path), "there": True}
    assert facts["method"]["input"] == "enhanced"
    assert facts["iterations"] == {"done": 40, "wanted": 40}
    assert facts["model"]["gaussians"] > 0
    assert told(runs["enhanced"] / "model.safetensors")["what"] == facts["what"]
    cut = tmp_path / "cut"
    events = run_training(request_of(clip_path, cut, config=replace(CONFIG, iterations=4000)))
    while not RunFolder(cut).has_checkpoint:
        next(events)
    events.close()
    facts = told(cut)
    assert facts["what"]["state"] == "not finished"
    assert facts["next"] == [f"vesselsplat train {clip_path} --run {cut} --resume"]


def test_splats_and_exports_say_what_they_were_made_from(
    runs: dict[str, Path],
    folder: Path,
    tmp_path: Path,
    vesselsplat: Cli,
    told: Told,
) -> None:
    assert vesselsplat("export", runs["original"], "--ply", tmp_path / "ply", "--frames", 3).code == 0
    (ply,) = (tmp_path / "ply").glob("*.ply")
    facts = told(ply)
    assert facts["what"] == {"kind": "splats", "format": ".ply"}
    assert facts["model"]["gaussians"] > 0
    assert facts["run"]["name"] == "original"
    (tmp_path / "made").mkdir()
    for suffix in ("png", "jpg", "webp"):
        assert vesselsplat("enhance", folder / "1.png", tmp_path / f"made/out.{suffix}").code == 0
        facts = told(tmp_path / f"made/out.{suffix}")
        assert facts["what"] == {"kind": "export"}
        assert facts["export"] == "enhanced picture"
        assert facts["source"]["name"] == "1.png"
        assert len(facts["source"]["sha256"]) == 64
        assert facts["next"][0] == f"vesselsplat replay {tmp_path / 'made'}/out.{suffix}"
    assert told(tmp_path / "made/out.webp.json")["what"] == {"kind": "provenance"}


def test_the_report_of_a_tuning_is_no_provenance_of_a_file_that_is_gone(
    tmp_path: Path, told: Told, vesselsplat: Cli
) -> None:
    write_image(tmp_path / "a.png", tissue(1), {})
    out = tmp_path / "out"
    assert vesselsplat("tune", tmp_path / "a.png", "--out", out, "--vary", "d_factor=0,2").code == 0
    facts = told(out / "tuning.json")
    assert facts["what"] == {"kind": "tuning"}
    assert facts["source"]["name"] == "a.png"
    assert "export" not in facts


def test_a_session_also_one_whose_source_is_gone(
    clip_path: Path, tmp_path: Path, told: Told, vesselsplat: Cli
) -> None:
    path = tmp_path / "s.vesselsplat"
    write_session(path, Session(source=SessionSource(str(clip_path)), frame=3, notes="look here"))
    facts = told(path)
    assert facts["what"] == {"kind": "session"}
    assert facts["source"] == {"path": str(clip_path), "there": True}
    assert (facts["frame"], facts["notes"]) == (3, "look here")
    write_session(path, Session(source=SessionSource("gone")))
    assert not told(path)["source"]["there"]
    path.write_text("{")
    call = vesselsplat("info", path)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert [entry.name for entry in tmp_path.iterdir()] == ["s.vesselsplat"]


def test_folders_that_are_no_clip_themselves(folder: Path, tmp_path: Path, told: Told) -> None:
    cases = tmp_path / "cases"
    for name in ("anna", "bert"):
        shutil.copytree(folder, cases / name)
    facts = told(cases)
    assert facts["what"] == {"kind": "folder"}
    assert facts["folders"] == ["anna", "bert"]
    assert facts["next"][1] == f"vesselsplat enhance {cases} OUT --recursive"
    videos = tmp_path / "videos"
    videos.mkdir()
    (videos / "a.mp4").write_bytes(b"x")
    assert told(videos)["videos"] == ["a.mp4"]
    cv2.imwrite(str(folder / "9.png"), np.zeros((20, 20, 3), np.uint8))
    facts = told(folder)
    assert facts["what"] == {"kind": "pictures"}
    assert "(9.png)" in facts["missing"][0]
    assert facts["next"] == [f"vesselsplat enhance {folder} OUT"]


@pytest.mark.parametrize("name", ["nothing", "empty", "text.png", "text.mp4", "other.json", "cut.ply"])
def test_what_cannot_be_read_is_one_line(tmp_path: Path, vesselsplat: Cli, name: str) -> None:
    (tmp_path / "empty").mkdir()
    for each in ("text.png", "text.mp4", "cut.ply"):
        (tmp_path / each).write_text("ply\n")
    (tmp_path / "other.json").write_text("{}")
    call = vesselsplat("info", tmp_path / name)
    assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
    assert name in call.error


def test_without_a_path_it_tells_the_versions(vesselsplat: Cli) -> None:
    facts = json.loads(vesselsplat("info", "--json").out)
    assert "packages" in facts


def test_a_report_is_known_by_its_folder_and_its_page(tmp_path: Path, told: Told) -> None:
    folder = tmp_path / "report"
    folder.mkdir()
    section = {"title": "Images"}
    facts = {
        "clip": {"name": "liver"},
        "utc": "2026-01-02T03:04:05",
        "machine": {},
        "parts": {"images": section},
    }
    (folder / "report.json").write_text(json.dumps(facts | {"app": "VesselSplat", "version": "0.2.0"}))
    (folder / "report.html").write_text("<html></html>")
    first, *others = (told(path) for path in (folder / "report.json", folder / "report.html", folder))
    assert first["what"]["kind"] == "report"
    assert [{**one, "path": first["path"]} for one in others] == [first, first]


def test_the_frame_of_saved_panes_is_its_number_and_its_name(tmp_path: Path, vesselsplat: Cli) -> None:
    facts = provenance(kind="panes", frame={"index": 4, "label": "a.png"})
    write_image(tmp_path / "panes.png", np.zeros((4, 6, 3), np.uint8), facts)
    text, values = (vesselsplat("info", tmp_path / "panes.png", *flags).out for flags in ((), ("--json",)))
    assert "frame        4: a.png" in text
    assert json.loads(values)["frame"] == {"index": 4, "label": "a.png"}
