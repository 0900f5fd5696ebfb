"""fvv.capture, the former name of fvv_capture: the same modules, with a warning."""

import subprocess
import sys

import pytest

USE = """
import fvv.capture
from fvv.capture.calibrate import boards
from fvv.capture.choices import UPS
import fvv.capture.progress as progress
import fvv_capture.calibrate.boards, fvv_capture.choices, fvv_capture.progress, sys
assert boards is fvv_capture.calibrate.boards and progress is fvv_capture.progress
assert UPS is fvv_capture.choices.UPS
assert boards.__spec__.name == boards.__name__ == "fvv_capture.calibrate.boards"
try:
    import fvv.capture.nothing
except ModuleNotFoundError as error:
    assert error.name == "fvv.capture.nothing"
else:
    sys.exit("a module that does not exist was imported")
"""


def called(*arguments):
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=120)


def test_the_former_name_has_the_same_modules_and_warns():
    done = called("-W", "default", "-c", USE)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("DeprecationWarning: fvv.capture is now the package fvv_capture") == 1


def test_the_warning_is_an_error_where_warnings_are():
    done = called("-W", "error", "-c", "import fvv.capture")
    assert done.returncode == 1 and "fvv_capture" in done.stderr
    assert called("-W", "error", "-c", "import fvv_capture").returncode == 0


@pytest.mark.parametrize("name", ["fvv.capture", "fvv_capture"])
def test_both_names_are_the_command(name):
    done = called("-m", name, "--version")
    assert done.returncode == 0 and done.stdout.startswith("fvvcapture "), done.stderr
