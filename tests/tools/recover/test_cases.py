"""fvvrecover on every case of the conformance suite."""

import concurrent.futures
import json

import pytest
from conftest import CONFORMANCE, Tool, read_json
from recover_oracle import offsets

CASES = CONFORMANCE / "cases"


def recover(folder, case):
    out = folder / f"{case.name}.fvv"
    done = Tool("fvvrecover")(case / "input.fvv", "-o", out, "--json")
    assert done.returncode in (0, 1, 3), (case.name, done.stderr)
    return done.returncode, read_json(done, "fvvrecover"), out


def check_faulty(folder, case):
    code, report, out = recover(folder, case)
    assert code != 0, case.name
    assert report["problem_count"] or report["state"] == "unfinished", case.name
    expected = json.loads((case / "expected.json").read_text())
    kept = report["frames"]["kept"]
    if code == 1:
        assert kept == 0 and not out.exists(), case.name
        return
    done = Tool("fvvinfo")("--check", "--json", out)
    assert (done.returncode, done.stderr) == (0, b""), (case.name, done.stderr)
    file = json.loads(done.stdout)["files"][0]
    assert file["frames"] == file["whole_frames"] == kept, case.name
    # What the suite does not call whole is not kept as whole.
    if "frames" in expected:
        whole = {int(frame["time"]) for frame in expected["frames"]}
        for run_of in file["whole"]:
            assert {int(run_of["first_time"]), int(run_of["last_time"])} <= whole, case.name


def check_whole(folder, case):
    code, report, out = recover(folder, case)
    content = (case / "input.fvv").read_bytes()
    if report["state"] == "unfinished":
        # A live stream: its groups stay as they are. A block that no group follows has no effect.
        ends = [at + size for at, kind, size in offsets(content) if kind == b"GEND"]
        assert code == (3 if ends else 1) and report["frames"]["lost"] == 0, case.name
        assert not ends or out.read_bytes()[: ends[-1]] == content[: ends[-1]], case.name
        return
    assert code == 0 and out.read_bytes() == content, case.name


@pytest.mark.parametrize("tier", ["valid", "uncommon", "faulty"])
def test_cases(tmp_path, tier):
    cases = sorted(path.parent for path in (CASES / tier).glob("*/input.fvv"))
    if not cases:
        pytest.skip(f"no cases in conformance/cases/{tier}")
    check = check_faulty if tier == "faulty" else check_whole
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for done in [pool.submit(check, tmp_path, case) for case in cases]:
            done.result()
