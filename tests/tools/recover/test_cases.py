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
    """The path of what is kept, None: nothing; and the report."""
    code, report, out = recover(folder, case)
    assert code != 0, case.name
    assert report["problem_count"] or report["state"] == "unfinished", case.name
    if code == 1:
        assert report["frames"]["kept"] == 0 and not out.exists(), case.name
    return (out if code == 3 else None), report


def check_kept(case, report, file):
    """file: what fvvinfo --check says of the new stream."""
    assert (file["integrity"], file["problems"]) == ("complete", []), case.name
    assert file["frames"] == file["whole_frames"] == report["frames"]["kept"], case.name
    # What the suite does not call whole is not kept as whole.
    expected = json.loads((case / "expected.json").read_text())
    # Readers stop at a damaged signature; here the chunks after it are kept.
    if "frames" in expected and expected["issues"][:1] != [{"issue": "FVV-1001", "offset": 0}]:
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
        done = [pool.submit(check, tmp_path, case) for case in cases]
        results = [future.result() for future in done]
    if tier != "faulty":
        return
    kept = [(case, report, path) for case, (path, report) in zip(cases, results) if path]
    checked = Tool("fvvinfo")("--check", "--json", *(path for _, _, path in kept))
    for (case, report, _), file in zip(kept, json.loads(checked.stdout)["files"]):
        check_kept(case, report, file)
