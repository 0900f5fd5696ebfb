"""Offsets beyond 4 GiB: a stream of 4.5 GB that is sparse on disk, read whole and by its index. No case can have one."""

import json
import os
import pathlib
import shutil
import subprocess

import pytest
from generate import meshes, recipes
from generate.packing import crc32c
from streams import ROOT

GROUPS, ZEROS = 280, 16 << 20
TOOLS = pathlib.Path(os.environ.get("FVV_TOOLS_DIR", ROOT / "build/default/tools"))


class SparseFile:
    """What a writer appends to. Of long pieces only the header is written, for the rest is zeros."""

    def __init__(self, file, content):
        self.file, self.size = file, 0
        self += content

    def __len__(self):
        return self.size

    def __iadd__(self, data):
        self.file.seek(self.size)
        self.file.write(data if len(data) < ZEROS else data[:64])
        self.size += len(data)
        self.file.truncate(self.size)
        return self


@pytest.fixture(scope="module")
def stream(tmp_path_factory):
    path = tmp_path_factory.mktemp("large") / "large.fvv"
    zeros = bytes(ZEROS)
    crc = crc32c(zeros)
    with path.open("wb") as file:
        s = recipes.opened()
        s.out = SparseFile(file, bytes(s.out))
        for i in range(GROUPS):
            s.begin(i, i + 1)
            # Private and ancillary: readers skip it.
            s.chunk("priv", zeros, time=i, payload_crc=crc)
            recipes.frame(s, i, meshes.TETRAHEDRON.moved(x=i))
            s.end()
        s.finish()
    if path.stat().st_blocks * 512 > 1 << 28:
        pytest.skip(f"{path.parent} is on a file system without sparse files")
    assert path.stat().st_size > 4.5e9
    return path


def test_check_reads_all_of_it(stream):
    done = subprocess.run([TOOLS / "fvvinfo/fvvinfo", "--json", stream], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (found,) = json.loads(done.stdout)["files"]
    assert (found["integrity"], found["problem_count"]) == ("complete", 0)


def test_python_seeks(stream):
    fvv = pytest.importorskip("fvv", reason="the Python package is not built: -DFVV_PYTHON_PACKAGE=ON")
    with fvv.open(stream) as clip:
        assert len(clip) == GROUPS
        for i in (GROUPS - 1, 0, 260):
            assert clip[i].mesh.positions[:, 0].max() == pytest.approx(0.1 + i / 1000)


def test_javascript_seeks(stream):
    if not shutil.which("node"):
        pytest.skip("no node installed")
    script = """
import { createServer } from "node:http";
import { createReadStream } from "node:fs";
import { createDecoder } from "./js/decoder/dist/index.js";
const [path, size, count] = [process.argv[1], Number(process.argv[2]), Number(process.argv[3])];
const server = createServer((request, response) => {
  const [, first, last] = /bytes=(\\d*)-(\\d*)/.exec(request.headers.range);
  const start = first ? Number(first) : size - Number(last);
  const end = first && last ? Math.min(Number(last), size - 1) : size - 1;
  response.writeHead(206, { "Content-Range": `bytes ${start}-${end}/${size}`, "Content-Length": end + 1 - start });
  createReadStream(path, { start, end }).pipe(response);
}).listen(0, "127.0.0.1", async () => {
  const decoder = await createDecoder({ source: `http://127.0.0.1:${server.address().port}/large.fvv`, queue: 1 });
  const found = [decoder.frameCount];
  for (const frame of [count - 1, 0, 260]) {
    await decoder.seek({ frame });
    const one = await decoder.next();
    found.push(one.mesh.lattice[0]);
    one.close();
  }
  console.log(JSON.stringify(found));
  decoder.close();
  server.close();
  process.exit(0);
});
"""
    command = ["node", "--input-type=module", "-e", script, stream, str(stream.stat().st_size), str(GROUPS)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [GROUPS, 100 + GROUPS - 1, 100, 360]
