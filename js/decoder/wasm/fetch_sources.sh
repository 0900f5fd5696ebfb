#!/usr/bin/env bash
# Sources of libraries for the wasm builds: those of the Debian packages that the native library is built with, so that
# both decode with the same code. Needs neither root nor a deb-src entry: it asks the hosts that apt is set up with,
# with a list of its own. usage: fetch_sources.sh DIRECTORY FOLDER=PACKAGE..., such as draco=libdraco-dev
set -euo pipefail
[[ $# -ge 2 ]] || { echo "usage: fetch_sources.sh DIRECTORY FOLDER=PACKAGE..." >&2; exit 2; }
mkdir -p "$1"
cd "$1"
shift

# The source package of an installed package and its version; nothing when it is not installed.
source_of() {
  dpkg-query -W -f '${source:Package}=${source:Version}' "$1" 2>/dev/null || true
}

fetch() { # folder, binary package
  local source version=""
  source=$(source_of "$2")
  [[ "$source" == *=?* ]] || { echo "fetch_sources: $2 is not installed" >&2; exit 1; }
  [[ -f "$1.version" ]] && version=$(<"$1.version")
  [[ "$version" == "$source" && -d "$1" ]] && return
  prepare_lists
  rm -rf "$1" "$1.version"
  apt-get "${options[@]}" source --download-only -qq "$source" >&2
  dpkg-source --no-check -x "${source%%=*}"_*.dsc "$1" >/dev/null
  rm -f "${source%%=*}"_*
  echo "$source" >"$1.version"
}

options=()
prepare_lists() {
  [[ ${#options[@]} -eq 0 ]] || return 0
  mkdir -p apt/lists/partial
  apt-get indextargets --format 'deb-src $(SITE) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    grep '/debian' | sort -u >apt/sources.list
  # The hosts' keys are those that the system trusts already.
  options=(-o "Dir::Etc::SourceList=$PWD/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
    -o "Dir::State::Lists=$PWD/apt/lists" -o "Dir::Cache::srcpkgcache=" -o "Dir::Cache::pkgcache="
    -o APT::Sandbox::User=)
  apt-get "${options[@]}" update -qq >&2
}

for wanted in "$@"; do
  fetch "${wanted%%=*}" "${wanted#*=}"
done
