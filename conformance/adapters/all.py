"""The decoders of this project that speak the protocol: their commands, and why one cannot run here."""

import os
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ADAPTERS = ROOT / "conformance/adapters"


def build_folder():
    return pathlib.Path(os.environ.get("FVV_BUILD", ROOT / "build/default")).resolve()


def with_path(*folders):
    """A command that runs this Python with folders to import from."""
    return f"env PYTHONPATH={':'.join(map(str, folders))} {sys.executable}"


def commands():
    """By name: the command, and what has to exist for it."""
    build, decoder = build_folder(), ROOT / "js/decoder/dist/core.wasm.js"
    package = build / "bindings/python"
    native = build / "conformance/fvv_conformance_libfvv"
    drawing = build / "conformance/view/fvv_conformance_view"
    return {
        "libfvv": (str(native), native),
        "view": (str(drawing), drawing),
        "wasm": (f"node {ADAPTERS / 'js/node.mjs'}", decoder),
        "python": (f"{with_path(package)} {ADAPTERS / 'python_package.py'}", package / "fvv"),
        "reference": (f"{with_path(ROOT / 'conformance')} -m reference", ROOT / "conformance/reference"),
        "chromium": (f"node {ADAPTERS / 'js/browser.mjs'} chromium", decoder),
        "firefox": (f"node {ADAPTERS / 'js/browser.mjs'} firefox", decoder),
        "example.c": (
            str(build / "conformance/conformance_example"),
            build / "conformance/conformance_example",
        ),
        "example.mjs": (f"node {ROOT / 'conformance/examples/decoder.mjs'}", decoder),
        "example.py": (
            f"{sys.executable} {ROOT / 'conformance/examples/decoder.py'}",
            ROOT / "conformance/examples",
        ),
    }


#: Cases that an interface cannot show, although nothing is wrong.
LEFT_OUT = {
    # Two visibility tracks of one mesh with the same cameras: the package gives the weights of the first.
    "python": {"valid/vector_visibility_sheet"},
}


def cases_for(name, cases):
    return [case for case in cases if case.name not in LEFT_OUT.get(name, ())]


BROWSERS = {"chromium": "chromium", "firefox": "firefox-esr"}


def missing(name):
    """Why a decoder cannot run here; None: it can."""
    _, needed = commands()[name]
    if not needed.exists():
        return f"{needed} was not built"
    program = BROWSERS.get(name, "node" if needed.suffix == ".js" else None)
    if program and not shutil.which(os.environ.get(f"FVV_{name.upper()}", program)):
        return f"no {program} installed"
    if name in BROWSERS and not (ROOT / "js/node_modules/puppeteer-core").exists():
        return "no js/node_modules"
    return None
