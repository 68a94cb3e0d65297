"""Videos read and written unchanged: frames, seconds, grey levels, sound, and whether Chromium plays them.

python -m tests.benchmarks.video_round_trip OUT VIDEO...

Chromium is asked where it is on the path; it reads the files from a server on this machine's loopback.
"""

from __future__ import annotations

import functools
import http.server
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np

from app.files.image_files import ArrayImage
from app.files.image_series import Series, open_series
from app.files.video import write_video
from renderer.clip import ClipError

PAGE = """<pre id=o></pre><script>(async () => {
for (const name of %s) {
  const video = document.createElement('video'); video.muted = true; video.src = encodeURIComponent(name);
  const said = await new Promise(done => {
    setTimeout(() => done('no answer'), 9000);
    video.onerror = () => done('refused');
    video.onloadeddata = () => done('plays ' + video.duration.toFixed(2) + ' s');
  });
  o.textContent += name + '\\t' + said + '\\n';
}})()</script>"""


def main(out: Path, videos: list[Path]) -> None:
    out.mkdir(parents=True, exist_ok=True)
    print(
        f"{'video':18s} {'frames':>9s} {'seconds':>13s} {'levels':>7s} {'|levels|':>8s} {'ms':>6s}  notices"
    )
    written = []
    for video in videos:
        target = out / f"{video.name}.mp4"
        try:
            print(f"{video.name:18s} {row(video, target)}")
            written.append(target.name)
        except ClipError as error:
            print(f"{video.name:18s} refused: {error}")
    for line in played(out, written):
        print(line)


def row(video: Path, target: Path) -> str:
    """Frames and seconds in and out, mean difference of grey levels signed and not, time of a frame read."""
    series = open_series(video)
    began = time.perf_counter()
    given = [series.read(index) for index in range(len(series))]
    each = (time.perf_counter() - began) / len(series) * 1e3
    notices = write_video(target, iter(given), series.timing).notices
    again = open_series(target)
    apart = [difference(again, given, index) for index in range(min(len(again), len(given)))]
    signed, plain = np.mean([one.mean() for one in apart]), np.mean([np.abs(one).mean() for one in apart])
    told = "; ".join((*series.notices, *notices))
    counts, ends = f"{len(given)} > {len(again)}", f"{seconds(video):.2f} > {seconds(target):.2f}"
    return f"{counts:>9s} {ends:>13s} {signed:+7.2f} {plain:8.2f} {each:6.1f}  {told}"


def difference(again: Series, given: list[ArrayImage], index: int) -> ArrayImage:
    picture = again.read(index)
    return picture.astype(float) - given[index][: picture.shape[0], : picture.shape[1]]


def seconds(path: Path) -> float:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        told = stream.duration and stream.time_base and float(stream.duration * stream.time_base)
        return told or (container.duration or 0) / 1e6


def played(folder: Path, names: list[str]) -> Iterator[str]:
    """What Chromium says of each file."""
    browser = shutil.which("chromium")
    if browser is None:
        yield "Chromium is not installed: not tried there"
        return
    (folder / "page.html").write_text(PAGE % names)
    handler = functools.partial(Quiet, directory=str(folder))
    with (
        http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server,
        tempfile.TemporaryDirectory() as own,
    ):
        threading.Thread(target=server.serve_forever, daemon=True).start()
        flags = "--headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking"
        flags += f" --disable-sync --user-data-dir={own} --virtual-time-budget=60000 --dump-dom"
        address = f"http://127.0.0.1:{server.server_port}/page.html"
        page = subprocess.run([browser, *flags.split(), address], capture_output=True, text=True, check=False)
        server.shutdown()
    yield from re.findall(r"[^\n>]+\t[^\n<]+", page.stdout)


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        """Nothing."""


if __name__ == "__main__":
    main(Path(sys.argv[1]), [Path(name) for name in sys.argv[2:]])
