"""Debian packages of this build, taken apart and used; and one version in all places that name it.

FVV_BUILD: the build's folder.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

SOURCE = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ["FVV_BUILD"])
VERSION = re.search(r"project\(fvv VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
SERIES = VERSION.rsplit(".", 1)[0]
PACKAGES = {
    "library": f"libfvv{SERIES}",
    "encoder": f"libfvv-encoder{SERIES}",
    "dev": "libfvv-dev",
    "tools": "fvv-tools",
}
TOOLS = {"compare", "demux", "import", "info", "mux", "recover", "render", "serve", "synth"}


def run(*command, **more):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("packages")
    run("cpack", "-G", "DEB", "-B", folder, cwd=BUILD)
    return {part: next(folder.glob(f"{name}_{VERSION}_*.deb")) for part, name in PACKAGES.items()}


@pytest.fixture(scope="module")
def root(packages, tmp_path_factory):
    """An empty root folder into which all of them were unpacked."""
    folder = tmp_path_factory.mktemp("root")
    for package in packages.values():
        run("dpkg-deb", "-x", package, folder)
    return folder


def field(package, name):
    return run("dpkg-deb", "-f", package, name).strip()


def test_packages_depend_on_the_libraries_that_they_load(packages):
    for part in ("library", "tools"):
        needed = field(packages[part], "Depends")
        assert re.search(r"\blibdraco\d+ ", needed) and re.search(r"\blibc6 ", needed), needed
    assert re.search(r"\blibavcodec\d+ ", field(packages["tools"], "Depends"))
    assert not re.search("libav|libpng|libfvv", field(packages["library"], "Depends"))
    assert f"libfvv{SERIES} (= {VERSION})" in field(packages["dev"], "Depends")


def test_each_file_is_in_one_package_and_below_usr(packages):
    owner = {}
    for part, package in packages.items():
        for line in run("dpkg-deb", "-c", package).splitlines():
            if line.startswith("d"):
                continue
            name = line.split(None, 5)[5].split(" -> ")[0]
            assert name.startswith("./usr/"), name
            assert owner.setdefault(name, part) == part, name
    assert {Path(name).name for name, part in owner.items() if part == "tools" and "/bin/" in name} >= {
        f"fvv{tool}" for tool in TOOLS
    }
    library = {Path(name).name for name, part in owner.items() if part == "library" and "libfvv.so" in name}
    assert library == {f"libfvv.so.{SERIES}", f"libfvv.so.{VERSION}"}
    encoder = {Path(name).name for name, part in owner.items() if part == "encoder" and ".so" in name}
    assert encoder == {f"libfvv_encoder.so.{SERIES}", f"libfvv_encoder.so.{VERSION}"}


def test_each_package_has_the_licences(packages, root):
    for part, package in packages.items():
        folder = root / "usr/share/doc" / PACKAGES[part]
        assert (folder / "LICENSE").read_bytes() == (SOURCE / "LICENSE").read_bytes()
        text = (folder / "copyright").read_text()
        for words in ("Draco", "meshoptimizer", "Copyright (c) 2013-2022 Niels Lohmann", "x264"):
            assert words in text, words
        names = run("dpkg-deb", "-c", package)
        assert f"./usr/share/doc/{PACKAGES[part]}/copyright" in names


BINARIES = {"library": "libfvv.so", "encoder": "libfvv_encoder.so", "tools": "fvvmux"}


@pytest.mark.parametrize("product", BINARIES)
def test_a_bill_of_materials_is_valid_and_whole(root, tmp_path, product):
    """Every library that dpkg says a package needs is in it."""
    binary = next(
        path for path in root.rglob(BINARIES[product]) if path.is_file() and "share" not in path.parts
    )
    bill = tmp_path / "bill.cdx.json"
    run(
        sys.executable,
        SOURCE / "packaging/sbom.py",
        "--product",
        product,
        "--name",
        product,
        "-o",
        bill,
        binary,
    )
    text = bill.read_text()
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None
    found = json.loads(text)
    assert found["metadata"]["component"]["version"] == VERSION
    by_name = {one["name"]: one for one in found["components"]}
    assert {"draco", "meshoptimizer", "glibc"} <= by_name.keys()
    assert all(one["licenses"] for one in found["components"])
    if product != "library":
        assert {"FFmpeg", "nlohmann-json", "stb"} <= by_name.keys()
        codecs = run("ldd", binary)
        expected = "GPL-2.0-or-later" if "libx264" in codecs or "libx265" in codecs else "LGPL-2.1-or-later"
        assert by_name["FFmpeg"]["licenses"] == [{"license": {"id": expected}}]
    assert ("CLI11" in by_name) == (product == "tools") and ("FFmpeg" in by_name) == (product != "library")


def installed(package):
    return run("dpkg-query", "-W", "-f", "${Version}", package)


NPM = {
    "analysis": {"@fvv/shading"},
    "decoder": {"draco", "emscripten", "llvm-runtime", "meshoptimizer", "musl"},
    "player": {
        "@fvv/analysis",
        "@fvv/decoder",
        "@fvv/shading",
        "draco",
        "emscripten",
        "llvm-runtime",
        "meshoptimizer",
        "musl",
    },
    "shading": set(),
    "three": {"@fvv/analysis", "@fvv/decoder", "@fvv/player", "@fvv/shading"},
    "video-fallback": {"FFmpeg", "emscripten", "llvm-runtime", "musl"},
}


@pytest.mark.parametrize("name", json.loads((SOURCE / "js/package.json").read_text())["workspaces"])
def test_a_bill_of_an_npm_package_is_valid_and_whole(tmp_path, name):
    bill = tmp_path / "bill.cdx.json"
    run(sys.executable, SOURCE / "packaging/sbom.py", "--npm", SOURCE / "js" / name, "-o", bill)
    text = bill.read_text()
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None
    found = json.loads(text)
    by_name = {one["name"]: one for one in found.get("components", [])}
    assert by_name.keys() == NPM[name]
    own = found["metadata"]["component"]
    manifest = json.loads((SOURCE / "js" / name / "package.json").read_text())
    assert own["licenses"] == [{"license": {"id": manifest["license"]}}]
    assert own["purl"] == f"pkg:npm/%40fvv/{name}@{VERSION}"
    for one in by_name.values():
        assert one["licenses"]
    if "draco" in by_name:
        assert by_name["draco"]["version"] == installed("libdraco-dev")
        assert by_name["meshoptimizer"]["version"] == installed("libmeshoptimizer-dev")
    if name == "video-fallback":
        assert by_name["FFmpeg"]["licenses"] == [{"license": {"id": "LGPL-2.1-or-later"}}]
    # What the package has a licence of is in its bill.
    for file in (SOURCE / "js" / name / "dist").glob("LICENSE.*"):
        assert file.suffix[1:] in by_name


def test_notices_name_all_that_is_compiled_into_a_package():
    notices = (SOURCE / "packaging/NOTICES").read_text()
    components = json.loads((SOURCE / "packaging/components.json").read_text())["components"]
    words = {"nlohmann-json": "nlohmann/json", "llvm-runtime": "libc++"}
    for one in components:
        if one.get("compiled_into"):
            assert re.search(
                rf"^  {re.escape(words.get(one['name'], one['name']))} ", notices, re.M | re.I
            ), one["name"]


def test_a_library_without_a_licence_ends_the_bill(tmp_path):
    done = subprocess.run(
        [sys.executable, SOURCE / "packaging/sbom.py", "--product", "tools", "--name", "x", "-o", tmp_path / "x", "/usr/bin/dpkg"],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 1 and "components.json has no licence for lib" in done.stderr
    assert not (tmp_path / "x").exists()


def test_tools_of_an_unpacked_package_work(root, tmp_path):
    binaries = root / "usr/bin"
    for tool in TOOLS:
        assert run(binaries / f"fvv{tool}", "--version") == f"fvv{tool} {VERSION}\n"
    small = ("--rig", "small", "--cameras", "3", "--frames", "2", "--size", "96x64")
    run(binaries / "fvvsynth", "-o", tmp_path / "capture", *small)
    run(binaries / "fvvmux", tmp_path / "capture", "-o", tmp_path / "players.fvv")
    assert json.loads(run(binaries / "fvvinfo", "--check", "--json", tmp_path / "players.fvv"))


def test_a_c_program_builds_against_an_unpacked_package(root, tmp_path):
    library = next(root.rglob("libfvv.so")).parent
    settings = {**os.environ, "PKG_CONFIG_PATH": str(library / "pkgconfig"), "LD_LIBRARY_PATH": str(library)}
    flags = run("pkg-config", "--cflags", "--libs", "fvv", env=settings).split()
    source = SOURCE / "packaging/conan/test_package/try.c"
    run(os.environ.get("CC", "cc"), "-std=c99", "-Wall", "-Werror", source, "-o", tmp_path / "try", *flags)
    assert run(tmp_path / "try", env=settings) == f"fvv {VERSION}\n"


def test_all_places_name_the_same_version():
    found = {}

    def look(path, pattern):
        found[path] = re.search(pattern, (SOURCE / path).read_text(), re.M).group(1)

    look("CITATION.cff", r"^version: (\S+)$")
    look("packaging/vcpkg/vcpkg.json", r'"version-semver": "(.+)"')
    look("packaging/homebrew/fvv.rb", r'tag: "v(.+)"')
    for path in sorted((SOURCE / "js").glob("*/package.json")):
        package = json.loads(path.read_text())
        if not package.get("private"):
            found[str(path.relative_to(SOURCE))] = package["version"]
    assert len(found) >= 8
    assert set(found.values()) == {VERSION}, found


def test_versions_of_the_python_package_and_of_conan_are_read_from_cmake():
    assert 'input = "CMakeLists.txt"' in (SOURCE / "pyproject.toml").read_text()
    recipe = (SOURCE / "packaging/conan/conanfile.py").read_text()
    assert "project\\(fvv VERSION" in recipe


def test_recipes_name_the_options_that_exist():
    options = set(re.findall(r"^option\((FVV_\w+)", (SOURCE / "CMakeLists.txt").read_text(), re.M)) | {
        "FVV_SOVERSION"
    }
    for path in ("vcpkg/portfile.cmake", "homebrew/fvv.rb", "conan/conanfile.py"):
        named = set(re.findall(r"FVV_\w+", (SOURCE / "packaging" / path).read_text()))
        assert named and named <= options, path


@pytest.mark.parametrize(
    "options, way_out",
    [(["-DFVV_TOOLS=OFF", "-DFVV_PYTHON_PACKAGE=ON"], ""), ([], "-DFVV_TOOLS=OFF to build libfvv alone")],
    ids=["python", "tools"],
)
def test_a_build_names_all_packages_that_are_missing(tmp_path, options, way_out):
    """pip install, on a machine where nothing is installed: once, and not one package after another."""
    hidden = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("Eigen3", "EXPAT", "nlohmann_json")]
    done = subprocess.run(
        ["cmake", "-S", SOURCE, "-B", tmp_path, "-DFVV_TESTS=OFF", *options, *hidden],
        capture_output=True, text=True, timeout=240, env=os.environ | {"PKG_CONFIG_LIBDIR": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 1 and done.stderr.count("CMake Error") == 1, done.stderr
    line = re.search(r"sudo apt-get install (.*)", done.stderr)[1].split()
    of_modules = {
        "draco",
        "turbojpeg0",
        "png",
        "webp",
        "openexr",
        "avcodec",
        "avformat",
        "avutil",
        "swscale",
        "swresample",
    }
    others = {"libexpat1-dev", "libeigen3-dev", "nlohmann-json3-dev"}
    assert set(line) == {f"lib{name}-dev" for name in of_modules} | others
    assert way_out in " ".join(done.stderr.split())
    assert way_out or "libfvv alone" not in done.stderr
