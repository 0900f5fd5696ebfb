"""A bill of materials in CycloneDX (JSON): what is compiled into binaries and which shared libraries they load; what is in an npm package.

    python packaging/sbom.py --product tools --name fvv-tools -o fvv-tools.cdx.json BINARY...
    python packaging/sbom.py --npm js/player -o fvv-player.cdx.json

Licences are those of components.json, which has to know every library; versions are those of this machine. FFmpeg counts as GPL where it has
x264 or x265. Needs cyclonedx-python-lib, readelf, and dpkg for versions.
"""

import argparse
import importlib.metadata
import json
import pathlib
import re
import shutil
import subprocess
import sys

from cyclonedx.model import ExternalReference, ExternalReferenceType, XsUri
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.license import DisjunctiveLicense, LicenseExpression
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL

HERE = pathlib.Path(__file__).resolve().parent
KNOWN = json.loads((HERE / "components.json").read_text())["components"]
PRODUCTS = ("library", "encoder", "tools", "python")


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    return done.stdout if done.returncode == 0 else ""


def version():
    text = (HERE.parent / "CMakeLists.txt").read_text()
    return re.search(r"project\(fvv VERSION ([\d.]+)", text).group(1)


def needed(binary):
    """Names of the shared libraries that a binary loads itself, such as "libz.so.1"."""
    listed = run("readelf", "-d", binary)
    if "Dynamic section" not in listed:
        sys.exit(f"sbom: {binary}: expected an ELF file that loads libraries")
    return re.findall(r"\(NEEDED\).*\[(.+)\]", listed)


def paths_of(binary):
    """Where the loader finds libraries, by name."""
    return dict(re.findall(r"^\s*(\S+) => (/\S+)", run("ldd", binary), re.M))


def debian_of(path):
    """(package, version) that has a file; (None, None): dpkg does not know it."""
    for name in (path, pathlib.Path(path).resolve()):
        for form in (str(name), str(name).removeprefix("/usr")):
            owner = run("dpkg-query", "-S", form).partition(": ")[0].split(":")[0]
            if owner:
                return owner, run("dpkg-query", "-W", "-f", "${Version}\n", owner).split("\n")[0]
    return None, None


def has_gpl_codecs(path):
    """Whether libavcodec loads x264 or x265."""
    return any(re.match(r"libx26[45]\.", name) for name in needed(path))


def component(known, version_found, package=None, license=None):
    license = license or known["license"]
    simple = re.fullmatch(r"[\w.+-]+", license)
    return Component(
        type=ComponentType.LIBRARY,
        name=known["name"],
        version=version_found,
        bom_ref=known["name"],
        licenses=[DisjunctiveLicense(id=license) if simple else LicenseExpression(license)],
        purl=PackageURL("deb", "debian", package, version_found) if package else None,
        external_references=[ExternalReference(type=ExternalReferenceType.WEBSITE, url=XsUri(known["url"]))],
    )


def emscripten_version(part):
    """Of a library that Emscripten brings with it; None: it is not here, or does not say."""
    compiler = shutil.which("emcc")
    system = pathlib.Path(compiler).resolve().parent / "system/lib" if compiler else HERE
    for name, pattern in (("VERSION", r"^(\S+)"), ("include/__config", r"_LIBCPP_VERSION (\d+)")):
        if (file := system / part / name).is_file():
            return re.search(pattern, file.read_text()).group(1)
    return None


def compiled_into(product):
    """What components.json says, by name, with the versions of this machine."""
    found = {}
    for known in KNOWN:
        if product not in known.get("compiled_into", ()):
            continue
        package = known.get("debian")
        if package:
            number = run("dpkg-query", "-W", "-f", "${Version}", package)
        elif "python" in known:
            number = importlib.metadata.version(known["python"])
        else:
            number = emscripten_version(known["emscripten"])
        found[known["name"]] = component(known, number or None, package if number else None)
    return found


def npm_purl(name, number):
    scope, _, rest = name.rpartition("/")
    return PackageURL("npm", scope or None, rest, number)


def npm_bill(folder):
    """Of a package of js: the packages that npm installs with it, and what is compiled into its wasm."""
    manifest = json.loads((folder / "package.json").read_text())
    found = compiled_into(manifest["name"])
    for name, number in manifest.get("dependencies", {}).items():
        # All of them are ours, and beside this one.
        other = json.loads((folder.parent / name.rpartition("/")[2] / "package.json").read_text())
        found[name] = Component(
            type=ComponentType.LIBRARY,
            name=name,
            version=number,
            bom_ref=name,
            licenses=[DisjunctiveLicense(id=other["license"])],
            purl=npm_purl(name, number),
        )
    own = {"name": manifest["name"], "version": manifest["version"]}
    return bom_of(
        Component(
            type=ComponentType.LIBRARY,
            bom_ref=manifest["name"],
            licenses=[DisjunctiveLicense(id=manifest["license"])],
            purl=npm_purl(*own.values()),
            **own,
        ),
        found,
    )


def bom_of(product, found):
    bom = Bom()
    bom.metadata.component = product
    for one in found.values():
        bom.components.add(one)
    bom.register_dependency(product, list(found.values()))
    return bom


def bill(product, name, binaries):
    """The Bom. Exits with the names of libraries that components.json does not know."""
    found, unknown = {}, set()
    for binary in binaries:
        paths = paths_of(binary)
        for library in needed(binary):
            stem = library.partition(".so")[0]
            if stem.startswith("libfvv"):
                continue  # our own, in a package beside
            known = next((one for one in KNOWN if stem in one.get("libraries", ())), None)
            if known is None:
                unknown.add(f"{library} (of {binary})")
                continue
            path = paths.get(library)
            package, number = debian_of(path) if path else (None, None)
            gpl = stem == "libavcodec" and path is not None and has_gpl_codecs(path)
            if known["name"] not in found or gpl:
                found[known["name"]] = component(known, number, package, known["gpl"] if gpl else None)
    if unknown:
        sys.exit(f"sbom: packaging/components.json has no licence for {', '.join(sorted(unknown))}")
    found.update(compiled_into(product))
    own = Component(
        type=ComponentType.LIBRARY if product in ("library", "encoder") else ComponentType.APPLICATION,
        name=name,
        version=version(),
        bom_ref=name,
        licenses=[DisjunctiveLicense(id="Apache-2.0")],
    )
    return bom_of(own, found)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--product", choices=PRODUCTS, help="of the binaries")
    arguments.add_argument("--name", help="of the package that has the binaries")
    arguments.add_argument(
        "--npm", type=pathlib.Path, metavar="FOLDER", help="of a package, in place of binaries"
    )
    arguments.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments.add_argument("binaries", nargs="*", type=pathlib.Path)
    given = arguments.parse_args()
    if bool(given.npm) == bool(given.product and given.name and given.binaries):
        arguments.error("expected --npm, or --product, --name and binaries")
    bom = npm_bill(given.npm) if given.npm else bill(given.product, given.name, given.binaries)
    given.output.write_text(JsonV1Dot6(bom).output_as_string(indent=2) + "\n")


if __name__ == "__main__":
    main()
