"""What is written is whole or not there, and nothing of anybody else's is ever deleted."""

from __future__ import annotations

import json
import os
import platform
import resource
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import IS_ACCEPTANCE
from test_cli import run

import pytracker as pt
from pytracker import output
from pytracker.formats import video_write
from pytracker.output import MADE_HERE, check_target, whole_file, whole_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and links as Unix has them")

KILLS = int(os.environ.get("PYTRACKER_KILLS", "5"))
"""How many random kills a command gets; 200 before a release."""


def write(target: Path, text: str, *, force: bool = False) -> None:
    with whole_folder(target, force=force) as out:
        (out / "a.txt").write_text(text)
        (out / "below").mkdir()
        (out / "below" / "b.txt").write_text(text)
        (out / "below" / MADE_HERE).write_text("{}")


def holds(target: Path) -> str:
    """What a whole folder of `write` holds; fails where it is not whole."""
    texts = {(target / name).read_text() for name in ("a.txt", "below/b.txt")}
    assert len(texts) == 1
    assert output._not_as_written(target) == []
    return texts.pop()


def hidden(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir() if path.name.startswith(".")]


def test_a_file_in_the_way_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(pt.InputError, match=r"below: .*file is a file, expected a folder to write into"):
        write(tmp_path / "file" / "below", "new")


def test_a_folder_is_replaced_only_by_force_and_only_as_it_was_written(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "old")
    with pytest.raises(pt.InputError, match="already exists"):
        write(out, "new")
    write(out, "new", force=True)
    assert holds(out) == "new"
    for name in ("notes.txt", "below/notes.txt"):
        (out / name).write_text("mine")
        with pytest.raises(pt.InputError, match=f"{name} was not written by pytracker, or was changed since"):
            write(out, "third", force=True)
        (out / name).unlink()
    (out / "a.txt").write_text("edited by hand")
    with pytest.raises(pt.InputError, match=r"a\.txt was not written by pytracker, or was changed since"):
        write(out, "third", force=True)
    assert (out / "a.txt").read_text() == "edited by hand"
    assert hidden(tmp_path) == []


@pytest.mark.parametrize("force", [False, True])
def test_what_appears_meanwhile_stays_and_so_does_the_result(tmp_path: Path, force: bool) -> None:
    out = tmp_path / "out"

    def run_meanwhile() -> None:
        with whole_folder(out, force=force) as whole:
            (whole / "a.txt").write_text("result")
            out.mkdir()
            (out / "thesis.txt").write_text("years of work")

    with pytest.raises(pt.InputError, match=f"the new result is in {out}-1"):
        run_meanwhile()
    assert (out / "thesis.txt").read_text() == "years of work"
    assert (tmp_path / "out-1" / "a.txt").read_text() == "result"


def test_a_file_that_appears_in_the_old_result_meanwhile_stays(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "old")

    def run_meanwhile() -> None:
        with whole_folder(out, force=True) as whole:
            (whole / "a.txt").write_text("result")
            (out / "notes.txt").write_text("mine")

    with pytest.raises(pt.InputError, match=f"the new result is in {out}-1"):
        run_meanwhile()
    assert (out / "notes.txt").read_text() == "mine"
    assert (out / "a.txt").read_text() == "old"


def test_two_runs_with_one_name_both_keep_their_result(simulated: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pytracker", "track", str(simulated), "--out", "out", "--no-report", "--quiet"]
    both = [
        subprocess.Popen([*command, "--seed", seed], cwd=tmp_path, stderr=subprocess.PIPE, text=True)  # noqa: S603
        for seed in "12"
    ]
    said = [process.communicate(timeout=60)[1] for process in both]
    codes = sorted(process.returncode for process in both)
    seeds = [json.loads(file.read_text())["tracks"][0]["seed"] for file in sorted(tmp_path.glob("*/metadata.json"))]
    if codes == [0, 2] and "the new result is in" in "".join(said):
        assert sorted(seeds) == [1, 2]
    else:  # one was done before the other began
        assert codes == [0, 2]
        assert "already exists" in "".join(said)


def steps(tmp_path: Path, kill_at: int, swap: bool) -> int:
    """Replace an old result in another process that kills itself before its n-th change of the disk.

    Its exit status.
    """
    code = f"""
        import os, signal, sys
        from pathlib import Path
        from pytracker import output
        sys.path.insert(0, {str(Path(__file__).parent)!r})
        left = [{kill_at}]
        def counted(real):
            def call(*arguments, **options):
                left[0] -= 1
                if left[0] < 0:
                    os.kill(os.getpid(), signal.SIGKILL)
                return real(*arguments, **options)
            return call
        swapped = output._swapped if {swap} else lambda a, b: False
        output._swapped = counted(swapped)
        for name in ("rename", "unlink", "rmdir"):
            setattr(Path, name, counted(getattr(Path, name)))
        with output.whole_folder(Path("out"), force=True) as out:
            left[0] = {kill_at}
            for name in ("a.txt", "below/b.txt"):
                (out / name).parent.mkdir(exist_ok=True)
                (out / name).write_text("new")
            (out / "below" / output.MADE_HERE).write_text("{{}}")
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], cwd=tmp_path, check=False)  # noqa: S603
    return done.returncode


@pytest.mark.parametrize("swap", [True, False], ids=["swap", "no swap"])
def test_killed_at_every_step_of_the_replacing(tmp_path: Path, swap: bool) -> None:
    """Where two folders can be swapped one of the two is always there whole; where not, the next run puts it back."""
    if swap:
        (tmp_path / "x").mkdir()
        (tmp_path / "y").mkdir()
        if not output._swapped(tmp_path / "x", tmp_path / "y"):
            pytest.skip("this file system cannot swap two folders")
    seen = set()
    for kill_at in range(20):
        for left in tmp_path.iterdir():
            shutil.rmtree(left)
        write(tmp_path / "out", "old")
        status = steps(tmp_path, kill_at, swap)
        if not swap and not (tmp_path / "out").exists():
            with pytest.raises(pt.InputError, match="already exists"):
                check_target(tmp_path / "out")
        seen.add(holds(tmp_path / "out"))
        check_target(tmp_path / "out", force=True)
        assert hidden(tmp_path) == []
        if status == 0:
            break
    assert status == 0
    assert seen == {"old", "new"}


COMMANDS = {
    "track": ("track", "{recording}", "--out", "out", "--force", "--no-report", "--method", "layered"),
    "simulate": ("simulate", "arm", "out", "--force", "--set", "duration_s=1"),
    "demo": ("demo", "--out", "out", "--force", "--duration", "1", "--body-duration", "1"),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_killed_at_random_the_old_or_the_new_is_there(simulated: Path, tmp_path: Path, name: str) -> None:
    pick = np.random.default_rng(6)
    command = [sys.executable, "-m", "pytracker", *(word.format(recording=simulated) for word in COMMANDS[name])]
    began = time.monotonic()
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == 0  # noqa: S603
    lasts_s = time.monotonic() - began
    for _ in range(KILLS if name != "demo" else max(1, KILLS // 5)):
        process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # noqa: S603
        time.sleep(pick.uniform(0.3, 1.0) * lasts_s)
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert output._not_as_written(tmp_path / "out") == []
        assert len(list((tmp_path / "out").iterdir())) > 2
    check_target(tmp_path / "out", force=True, is_recording=True)
    assert hidden(tmp_path) == []


def test_what_others_left_hidden_stays(tmp_path: Path) -> None:
    mine = [f".out-{platform.node()}-{os.getpid()}-abc", ".out-elsewhere-99999999-abc", ".out-notes", ".outer"]
    for name in mine:
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").touch()
    dead = tmp_path / f".out-{platform.node()}-999999999-abc"
    dead.mkdir()
    (dead / MADE_HERE).touch()
    write(tmp_path / "out", "new")
    assert sorted(hidden(tmp_path)) == sorted(mine)


def test_a_full_disk_leaves_no_video_that_does_not_open(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk: OpenCV says nothing of either."""
    code = (
        "import resource, sys, pytracker as pt; resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000));"
        "pt.simulate_arm('out', pt.ArmScene(duration_s=3.0), 1)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)  # noqa: S603
    assert done.returncode != 0
    assert "frames could be written: is the disk full?" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("command", "name"), [("frame", "cycle.png"), ("inspect", "cycle.svg")])
def test_a_full_disk_leaves_no_half_of_a_picture(simulated: Path, tmp_path: Path, command: str, name: str) -> None:
    arguments = [sys.executable, "-m", "pytracker", command, str(simulated), "--frame", "9", "--out", name]
    done = subprocess.run(  # noqa: S603
        arguments, cwd=tmp_path, capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000)),
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_appears_meanwhile_stays(tmp_path: Path) -> None:
    path = tmp_path / "frame.png"

    def write_meanwhile() -> None:
        with whole_file(path, force=False) as partial:
            partial.write_text("new")
            path.write_text("mine")

    with pytest.raises(pt.InputError, match="appeared while this ran"):
        write_meanwhile()
    assert path.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_is_placed_where_no_hard_links_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a memory stick."""

    def refused(self: Path, target: Path) -> None:
        if self.exists():
            raise FileExistsError
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(Path, "hardlink_to", refused)
    path = tmp_path / "frame.png"
    with whole_file(path, force=False) as partial:
        partial.write_text("new")
    assert path.read_text() == "new"
    with pytest.raises(pt.InputError, match="appeared while this ran"), whole_file(path, force=False) as partial:
        partial.write_text("newer")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def stopped(command: list[str], folder: Path, wait_for: str, number: int = signal.SIGINT) -> tuple[int, str, float]:
    """Exit status, what was said on the error stream, and how long it took to stop, s."""
    handler = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
    process = subprocess.Popen(  # noqa: S603
        [sys.executable, "-m", "pytracker", *command], cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
        text=True, preexec_fn=lambda: signal.signal(number, handler),  # noqa: PLW1509
    )  # fmt: skip
    until = time.monotonic() + 60
    while time.monotonic() < until and not list(folder.glob(wait_for)) and process.poll() is None:
        time.sleep(0.01)
    began = time.monotonic()
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    return process.returncode, said, time.monotonic() - began


def test_the_overlay_is_not_waited_for(tmp_path: Path) -> None:
    recording = pt.simulate_arm(tmp_path / "recording", pt.ArmScene(duration_s=45.0), 1)
    command = ["track", str(recording), "--out", "out", "--method", "ekf"]
    for number in (signal.SIGINT, signal.SIGTERM) if IS_ACCEPTANCE else (signal.SIGTERM,):
        status, said, lasted_s = stopped(command, tmp_path, ".out-*/overlay.webm", number)
        assert status == 128 + number, said
        assert lasted_s < 5.0  # 2 s on a machine that does nothing else; the overlay takes 8 to 16
        assert "Traceback" not in said
        assert [path.name for path in tmp_path.iterdir()] == ["recording"]


def test_an_interrupted_import_prints_no_traceback(tmp_path: Path) -> None:
    for delay_s in (0.05, 0.1, 0.2, 0.3, 0.4):
        process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-m", "pytracker", "demo", "--out", str(tmp_path / "out")],
            stderr=subprocess.PIPE, text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # noqa: PLW1509
        )  # fmt: skip
        time.sleep(delay_s)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
        # Before the first line of the package it is Python that is interrupted.
        assert "Traceback" not in said or "pytracker" not in said, said
        assert process.returncode != 0


def test_a_signal_within_a_destructor_is_not_lost(tmp_path: Path) -> None:
    code = """
        import os, signal, sys, time
        from pytracker.cli import entry
        class Last:
            def __del__(self):
                os.kill(os.getpid(), signal.SIGTERM)
                time.sleep(0.05)
        entry._take_signals()
        last = Last()
        del last
        for _ in range(200):
            time.sleep(0.01)
        print("went on")
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False)  # noqa: S603
    assert (done.returncode, done.stdout) == (128 + 15, "")


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        ("ImportError('initialization failed')", 128 + 15, ""),
        ("OSError('not cleaned up')", 2, "pytracker: not cleaned up\n"),
    ],
)
def test_a_signal_within_an_import_is_no_internal_error(error: str, status: int, words: str) -> None:
    """Modules written in C make an ImportError of whatever is raised while they are set up; Matplotlib has some.

    What goes wrong in leaving is said all the same.
    """
    code = f"""
        import os, signal
        from pytracker.cli import entry
        def app():
            try:
                os.kill(os.getpid(), signal.SIGTERM)
            except SystemExit:
                raise {error} from None
        entry.app = app
        entry.main()
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False)  # noqa: S603
    assert (done.returncode, done.stderr) == (status, f"pytracker: stopping (again: at once)\n{words}")


def test_whoever_stops_reading_is_no_error(simulated: Path) -> None:
    command = f"{sys.executable} -m pytracker track --help | head -1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)  # noqa: S603, S607
    assert "Traceback" not in done.stderr
    assert "internal error" not in done.stderr
    closed = subprocess.run(  # noqa: S603
        ["bash", "-c", f"{sys.executable} -m pytracker evaluate {simulated} {simulated} >&-"],  # noqa: S607
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "internal error" not in closed.stderr


def test_a_link_that_loops_is_named(tmp_path: Path, simulated: Path) -> None:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    done = run("track", simulated, "--out", tmp_path / "loop")
    assert done.returncode == 2
    assert "internal error" not in done.stderr


def test_a_video_is_looked_at_after_it_was_written(tmp_path: Path) -> None:
    image = np.zeros((48, 64, 3), np.uint8)
    with video_write.VideoWriter(tmp_path / "a.mp4", "mp4v", 25.0, (64, 48)) as writer:
        for _ in range(5):
            writer.write(image)

    def write_another_size() -> None:
        with video_write.VideoWriter(tmp_path / "b.mp4", "mp4v", 25.0, (64, 48)) as writer:
            for _ in range(5):
                writer.write(image)
            writer.write(np.zeros((10, 10, 3), np.uint8))  # OpenCV drops it without a word

    with pytest.raises(OSError, match=r"5 of 6 frames could be written"):
        write_another_size()
