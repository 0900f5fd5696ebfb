"""Every sample of the documentation: fenced listings with a language, and what runs each."""

from __future__ import annotations

import dataclasses
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FOLDERS = ("docs", "spec", "js", "bindings", "conformance", "packaging")
# A record of what changed; its samples were right once.
SKIPPED = {"CHANGELOG.md"}
FENCE = re.compile(
    r"^(?:<!-- (?P<mark>run[^\n]*?) -->\n)?(?P<indent>[ \t]*)```(?P<language>\w+)\n(?P<text>.*?)^[ \t]*```$",
    re.S | re.M,
)

# How a sample is run, by (file, beginning of its text). What is not here is run by the runner of its language.
EACH_LINE = "each line in a folder of its own"  # they are alternatives, or repeat an output
OPTIONS = "options are parsed, because the films that it reads take minutes"
COMPILED = "compiled, and its names are looked up"

# What other tests run, or what cannot run here, with the reason.
ELSEWHERE = "by "
NOT = "not run: "
HOW = {
    ("README.md", "./run demo"): ELSEWHERE + "continuous integration itself",
    ("README.md", "cc -std=c99 consumer.c"): ELSEWHERE + "the test of the installation",
    ("docs/guide/encoder-in-c.md", "#include <fvv/encoder.h>"): ELSEWHERE + "the test of the installation",
    ("docs/guide/encoder-in-c.md", "cc -std=c99 clip.c"): ELSEWHERE + "the test of the installation",
    ("docs/tools/calibration.md", "fvvimport colmap sparse/0"): EACH_LINE,
    ("docs/tools/calibration.md", "fvvimport capture"): EACH_LINE,
    ("docs/evidence/fuzzing.md", "./run fuzz"): ELSEWHERE + "continuous integration itself",
    ("docs/tools/fvvcapture-calibrate.md", "fvvcapture calibrate"): OPTIONS,
    ("docs/tools/fvvcapture-hull.md", "from fvv_capture"): COMPILED,
    ("docs/tools/fvvcapture.md", "pip install .[capture]"): OPTIONS,
    ("docs/tools/fvvcapture.md", "fvvcapture shoot/performance"): OPTIONS,
    ("docs/tools/fvvcapture.md", "fvvcapture videos"): OPTIONS,
    ("docs/tools/fvvcapture.md", "# COLMAP and OpenMVS"): ELSEWHERE + "python: capture ways_in",
    ("docs/tools/fvvcapture.md", "import numpy, fvv"): ELSEWHERE + "python: capture ways_in",
    ("docs/tools/fvvcapture.md", "fvvmux --meshes"): ELSEWHERE + "python: capture ways_in",
    ("docs/project/abi.md", "python3 tests/install/abi.py"): ELSEWHERE + "install: binary interface",
    ("conformance/golden/README.md", "build/venv/bin/python"): ELSEWHERE + "conformance: golden",
    ("docs/tools/fvvmux-inputs.md", "fvvmux --meshes"): ELSEWHERE + "cli: inputs",
    ("docs/tools/fvvmux-inputs.md", "fvvmux project"): ELSEWHERE + "cli: inputs",
    ("docs/tools/fvvmux-inputs.md", "fvvmux scene"): ELSEWHERE + "cli: inputs",
    ("docs/tools/fvvserve.md", "fvvmux players -o players.fvv --segments"): EACH_LINE,
    ("docs/tools/fvvserve.md", "server {"): NOT
    + "a part of a configuration of nginx, which is not installed",
    ("docs/tools/fvvsynth.md", "fvvsynth --footage"): OPTIONS,
    ("docs/encoding/hdr.md", "fvvsynth -o big"): NOT + "a measurement",
    ("docs/evidence/matrix.md", "./run matrix"): NOT + "needs other compilers, and takes half an hour",
    ("docs/evidence/networks.md", "./run bench chaos"): ELSEWHERE + "js: chaos",
    ("docs/guide/your-own-capture.md", "fvvcapture shoot"): OPTIONS,
    ("docs/guide/command-line.md", "pip install .[capture]"): OPTIONS,
    ("docs/guide/live.md", "pip install .[live]"): NOT
    + "fvvserve listens until it is stopped, and there are no cameras; by python: capture live without it",
    ("docs/guide/live.md", "recorder |"): NOT + "the recorder is the reader's; by cli: frame_pipe",
    ("docs/guide/libraries.md", "cc -std=c99 consumer.c"): ELSEWHERE + "the test of the installation",
    ("docs/guide/libraries.md", "c++ -std=c++17"): ELSEWHERE + "the test of the installation",
    ("docs/guide/write-a-decoder.md", "pip install ./conformance"): ELSEWHERE
    + "the tests of the conformance runner",
    ("docs/guide/write-a-decoder.md", "fvv-conformance sweep"): ELSEWHERE
    + "the tests of the conformance runner",
    ("docs/guide/comparison.md", "ffmpeg -i"): NOT + "a file of another project",
    ("docs/guide/comparison.md", "pip install fourdgs"): NOT + "a program of another project",
    ("docs/guide/comparison.md", "npm install -g"): NOT + "a program of another project",
    ("docs/guide/comparison.md", "git clone"): NOT + "a program of another project",
    ("bindings/python/README.md", "pip install ."): ELSEWHERE + "./run wheels",
    ("bindings/python/README.md", "python -m fvv info"): ELSEWHERE + "python: command",
    ("bindings/python/README.md", "clip = fvv.open"): ELSEWHERE + "python: notebook",
    ("conformance/PROTOCOL.md", "pip install ./conformance"): ELSEWHERE
    + "the tests of the conformance runner",
    ("conformance/README.md", "python3 conformance/vectors.py"): ELSEWHERE + "the tests of the specification",
    ("conformance/reference/listings/README.md", "python3 conformance/vectors.py"): ELSEWHERE
    + "the tests of the specification",
    ("conformance/cases/README.md", "python3 conformance/generate.py"): ELSEWHERE + "cli: conformance_cases",
    ("conformance/kaitai/README.md", "node conformance/kaitai"): ELSEWHERE
    + "the test of the Kaitai description",
    ("conformance/reference/README.md", "cd conformance"): ELSEWHERE + "cli: reference",
    ("conformance/render/README.md", "conformance/run render"): ELSEWHERE + "the tests of conformance/render",
    ("packaging/README.md", "./run packages"): ELSEWHERE + "install: packages",
    ("js/docs/README.md", "node build.mjs"): ELSEWHERE + "js: docs: build",
    ("js/player/README.md", "npx esbuild"): ELSEWHERE + "js: docs: samples",
    ("js/player/README.md", "// vite.config.js"): ELSEWHERE + "js: vite dev",
    ("js/player/conformance/README.md", "node js/player"): ELSEWHERE + "./run bench player",
    ("js/site/README.md", "node build.mjs"): ELSEWHERE + "js: site",
    ("js/three/README.md", "(cd .. && npm ci"): ELSEWHERE + "js: three",
}
# What runs all samples of a language, unless HOW says something else; test_samples.py has those without "by".
LANGUAGES = {
    "sh": "in a folder with a capture and a stream",
    "jsx": ELSEWHERE + "js: packages",
    "tsx": ELSEWHERE + "js: samples",
    "json": "parsed, and compared with its schema",
    "js": ELSEWHERE + "js: docs: samples",
    "html": ELSEWHERE + "js: docs: samples",
}
# Those of bindings/python/tests/test_readme.py.
PYTHON_PAGES = {"bindings/python/README.md", "README.md", "docs/guide/python.md"}


@dataclasses.dataclass(frozen=True)
class Sample:
    file: str
    line: int
    language: str
    mark: str  # of the comment before it, "" without one
    text: str
    how: str

    @property
    def is_run(self) -> bool:
        return not self.how.startswith(NOT)

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


def pages() -> list[pathlib.Path]:
    found = sorted(ROOT.glob("*.md"))
    for folder in FOLDERS:
        found += sorted((ROOT / folder).rglob("*.md"))
    return [p for p in found if p.name not in SKIPPED and not {"node_modules", "dist"} & set(p.parts)]


def samples() -> tuple[list[Sample], set]:
    """All samples, and the rows of HOW that none of them needs. A sample that nothing runs has how ""."""
    found, unused = [], set(HOW)
    for path in pages():
        file = path.relative_to(ROOT).as_posix()
        content = path.read_text()
        for match in FENCE.finditer(content):
            text, language = match["text"], match["language"]
            row = next((r for r in HOW if r[0] == file and text.lstrip().startswith(r[1])), None)
            unused.discard(row)
            how = HOW[row] if row else LANGUAGES.get(language, "")
            if not row and language in {"python", "py"} and file in PYTHON_PAGES:
                how = ELSEWHERE + "python: readme"
            line = content.count("\n", 0, match.start("text"))
            found.append(Sample(file, line, language, match["mark"] or "", text, how))
    return found, unused


if __name__ == "__main__":
    everything, _ = samples()
    for sample in everything:
        print(f"{sample}: {sample.language}: {sample.how}")
    print(sum(s.is_run for s in everything), "of", len(everything), "run")
