"""The line of progress, on a terminal (a pty) and elsewhere."""

import fcntl
import os
import pathlib
import pty
import re
import signal
import struct
import subprocess
import termios
import time

import pytest

TOOLS = pathlib.Path(os.environ["FVV_TOOLS_DIR"]).resolve()
SMALL = [TOOLS / "fvvsynth/fvvsynth", "--rig", "small", "--cameras", "1", "--size", "64x48"]
CLEAR = "\r\x1b[K"


def on_terminal(folder, columns, term="xterm", frames=240):
    """What fvvsynth writes to a terminal of that width, line by line as it is drawn.

    It is stopped for a while at its first line: without that, a fast machine is done before a rate is shown.
    """
    terminal, program = pty.openpty()
    fcntl.ioctl(program, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    command = [*SMALL, "-o", folder / "out", "--frames", str(frames), "--threads", "1"]
    process = subprocess.Popen(
        command, stdin=program, stdout=program, stderr=program, env=os.environ | {"TERM": term}
    )
    os.close(program)
    written = b""
    while True:
        try:
            part = os.read(terminal, 65536)
        except OSError:  # closed by the last program that had it
            break
        if not part:
            break
        if not written:
            process.send_signal(signal.SIGSTOP)
            time.sleep(1.2)
            process.send_signal(signal.SIGCONT)
        written += part
    os.close(terminal)
    assert process.wait() == 0
    return written.decode()


@pytest.fixture(scope="module")
def wide(tmp_path_factory):
    return on_terminal(tmp_path_factory.mktemp("wide"), 100)


def test_line_has_rate_and_time_left(wide):
    drawn = wide.split(CLEAR)[1:]
    whole = re.compile(r"fvvsynth  \d+ of 240 frames  \d+ %  [\d.]+ frames/s  \d+ s left")
    assert any(whole.fullmatch(line) for line in drawn)
    counts = [int(line.split()[1]) for line in drawn if line]
    assert counts == sorted(set(counts))


def test_line_is_cleared_at_the_end(wide):
    assert wide.endswith(CLEAR) and "\n" not in wide


def test_line_fits_a_narrow_terminal(tmp_path):
    drawn = [line for line in on_terminal(tmp_path, 24).split(CLEAR) if line]
    assert drawn and max(map(len, drawn)) < 24
    assert all(" %" in line for line in drawn)


def test_nothing_without_a_terminal_that_can_clear_lines(tmp_path):
    assert on_terminal(tmp_path, 100, "dumb", 1) == ""
    done = subprocess.run([*SMALL, "-o", tmp_path / "piped", "--frames", "1"], capture_output=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
