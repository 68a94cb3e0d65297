"""Nothing leaves the computer: no command and no window opens a socket of the internet."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.app.conftest import ROOT

WATCH = """
import os, socket, sys

INTERNET = (socket.AF_INET, socket.AF_INET6)
LOCAL = "socket.__new__", "socket.gethostname", "socket.bind", "socket.connect"


def watch(event, facts):
    talks = event.startswith(("socket.", "urllib.", "http.", "ftplib.", "smtplib.", "webbrowser."))
    ours = event in LOCAL and getattr(facts[0] if facts else None, "family", None) not in INTERNET
    if event == "socket.__new__":
        ours = facts[1] not in INTERNET
    if talks and not ours:
        os.write(2, f"{event} {facts}".encode())
        os._exit(97)


sys.addaudithook(watch)
"""

COMMANDS = """
from app.__main__ import main

calls = '''
phantom clip --frames 8 --size 48 40
enhance clip/images enhanced --pixels tissue
enhance clip/images out.mp4
metrics enhanced --against clip/images --json
tune clip/images --vary d_factor=0:2:2 --out tuned
train clip --run run --iterations 6
render run --out pictures --frames test --depth
export run --ply ply --video film.mp4 --cameras cameras.json
evaluate run --json
replay pictures/frame-000001.png
replay film.mp4 --json
info
--help
'''
for call in calls.split("\\n"):
    if call and main(call.split()) != 0:
        sys.exit(call)
"""

WINDOW = """
from pathlib import Path

import psutil
from imgui_bundle import imgui

from app.gui.actions import actions, export_actions, session_actions
from app.gui.work.settings import Settings
from assets import phantom_path
from tests.app.gui.kept_session import places_in
from tests.app.gui.driver import Driver, is_settled, wait

driver = Driver(places_in(Path.cwd()), Settings())


def drive(ctx):
    ctx.item_click("//Before you begin/I understand")
    actions.open_path(driver.state, phantom_path())
    wait(ctx, lambda: is_settled(driver.state), "the phantom")
    export_actions.save_picture(driver.state)
    session_actions.save_to(driver.state, driver.state.places.pictures / "a.vesselsplat")
    wait(ctx, lambda: driver.state.window.toast is not None, "the saved files")


driver.run(drive)
sys.exit("a connection" if psutil.Process().net_connections("inet") else 0)
"""


def watched(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-c", WATCH + code]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=300, env=environment)


def test_the_watch_sees_what_it_should(tmp_path: Path) -> None:
    assert watched("socket.getaddrinfo('localhost', 80)", tmp_path).returncode == 97
    assert watched("socket.socket()", tmp_path).returncode == 97
    assert (
        watched("import urllib.request; urllib.request.urlopen('http://localhost')", tmp_path).returncode
        == 97
    )
    assert watched("socket.socketpair()", tmp_path).returncode == 0


@pytest.mark.slow
def test_no_command_opens_a_connection(tmp_path: Path) -> None:
    done = watched(COMMANDS, tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.display
def test_the_window_opens_no_connection(tmp_path: Path) -> None:
    done = watched(WINDOW, tmp_path)
    assert done.returncode == 0, done.stderr[-2000:] + done.stdout[-2000:]
