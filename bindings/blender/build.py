"""Makes the extension of Blender, one zip with a wheel of the Python package inside.

    python bindings/blender/build.py build/wheels/fvv-VERSION-cp311-....whl -o build/blender

Take a wheel that auditwheel repaired: Blender does not find libraries of the system elsewhere. The Python of the wheel has to be that of
Blender: 3.11 in Blender 4.1 to 5.0."""

import argparse
import pathlib
import re
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = ("__init__.py", "blender_manifest.toml")
NAME = re.compile(r"fvv-(?P<version>\d+\.\d+\.\d+)-cp(?P<python>\d+)-cp\d+-(?P<tag>[\w.]+)\.whl")
#: Blender's name for a wheel's platform tag.
SYSTEMS = {"linux": "linux", "macosx": "macos", "win": "windows"}
PROCESSORS = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64", "arm64": "arm64"}


def platform_of(tag):
    """Such as linux-x64, of manylinux_2_35_x86_64."""
    system = next(SYSTEMS[one] for one in SYSTEMS if one in tag)
    return f"{system}-{next(PROCESSORS[one] for one in PROCESSORS if tag.endswith(one))}"


def manifest(wheel):
    """The manifest of the extension that has this wheel inside: text of TOML."""
    found = NAME.fullmatch(wheel.name)
    if not found:
        raise ValueError(f"{wheel.name}: expected a wheel of fvv for one version of Python")
    given = {
        "version": f'"{found["version"]}"',
        "platforms": f'["{platform_of(found["tag"])}"]',
        "wheels": f'["./wheels/{wheel.name}"]',
    }
    text = (HERE / "blender_manifest.toml").read_text()
    for key, value in given.items():
        text, count = re.subn(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.M)
        assert count == 1, key
    return text


def build(wheel, folder):
    """Writes the extension into a folder and returns its path."""
    text, content = manifest(wheel), wheel.read_bytes()
    version = NAME.fullmatch(wheel.name)["version"]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"free_viewpoint_video-{version}-{platform_of(wheel.stem)}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        for name in SOURCES:
            out.writestr(name, text if name.endswith(".toml") else (HERE / name).read_text())
        out.writestr(f"wheels/{wheel.name}", content, zipfile.ZIP_STORED)
        out.write(HERE.parent.parent / "LICENSE", "LICENSE")
    return path


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("wheel", type=pathlib.Path)
    parser.add_argument("-o", dest="folder", type=pathlib.Path, default=pathlib.Path("build/blender"))
    given = parser.parse_args()
    try:
        print(build(given.wheel, given.folder))
    except (ValueError, OSError) as error:
        sys.exit(f"build.py: {error}")


if __name__ == "__main__":
    main()
