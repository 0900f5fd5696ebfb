"""Figures of the conformance suite, of the specification and of the golden streams: lines "name number" of the programs that measure
them."""

import re
import subprocess
import sys

LINE = re.compile(r"^([a-z_]+\.[a-z_]+):? (-?[0-9.]+)$", re.MULTILINE)


def printed(root, *command):
    """The figures that a Python program of the tree prints. Its exit code says whether they are good; they are figures all the same."""
    done = subprocess.run([sys.executable, *command], cwd=root, capture_output=True, text=True)
    found = {name: float(number) for name, number in LINE.findall(done.stdout)}
    if not found:
        sys.exit(f"bench: {' '.join(command)} ended with {done.returncode}: {done.stderr.strip()[-500:]}")
    return found


def golden(root):
    return printed(root, "conformance/golden.py")


def mutants(root):
    """Half an hour on two idle cores."""
    return printed(root, "conformance/mutants.py")


def conformance(root):
    """Without browsers and damages, which ./run conformance takes."""
    names = "libfvv,wasm,python,reference,view"
    return printed(root, "conformance/adapters/run_all.py", "--sweep", "0", "--decoders", names)


def words(root):
    return printed(root, "spec/generate.py", "--words")
