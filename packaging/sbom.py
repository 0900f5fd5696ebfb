"""A bill of materials in CycloneDX (JSON) for binaries: what is compiled into them, and which shared libraries they load.

    python packaging/sbom.py --product tools --name fvv-tools -o fvv-tools.cdx.json BINARY...

Licences are those of components.json, which has to know every library; versions are those of this machine. FFmpeg counts as GPL where it has
x264 or x265. Needs cyclonedx-python-lib, readelf, and dpkg for versions.
"""

import argparse
import importlib.metadata
import json
import pathlib
import re
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
    for known in KNOWN:
        if product not in known.get("compiled_into", ()):
            continue
        package = known.get("debian")
        number = (
            run("dpkg-query", "-W", "-f", "${Version}", package)
            if package
            else importlib.metadata.version(known["python"])
        )
        found[known["name"]] = component(known, number or None, package if number else None)
    bom = Bom()
    bom.metadata.component = Component(
        type=ComponentType.LIBRARY if product in ("library", "encoder") else ComponentType.APPLICATION,
        name=name,
        version=version(),
        bom_ref=name,
        licenses=[DisjunctiveLicense(id="Apache-2.0")],
    )
    for one in found.values():
        bom.components.add(one)
    bom.register_dependency(bom.metadata.component, list(found.values()))
    return bom


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--product", choices=PRODUCTS, required=True)
    arguments.add_argument("--name", required=True, help="of the package that has the binaries")
    arguments.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments.add_argument("binaries", nargs="+", type=pathlib.Path)
    given = arguments.parse_args()
    text = JsonV1Dot6(bill(given.product, given.name, given.binaries)).output_as_string(indent=2)
    given.output.write_text(text + "\n")


if __name__ == "__main__":
    main()
