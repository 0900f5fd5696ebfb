"""The runner notices every kind of disagreement, and survives decoders that die, hang or answer nonsense."""

import json
import pathlib
import sys
import textwrap
import xml.etree.ElementTree as ElementTree

import pytest

CONFORMANCE = pathlib.Path(__file__).resolve().parent.parent.parent / "conformance"
sys.path.insert(0, str(CONFORMANCE))

from fvv_conformance import cases, command, damage  # noqa: E402
from fvv_conformance.compare import describe_differences  # noqa: E402
from fvv_conformance.decoder import Decoder, DecoderError  # noqa: E402
from fvv_conformance.sweep import judge  # noqa: E402

PARTS = frozenset(("check", "mesh", "camera", "sound", "environment"))
WHOLE = {
    "status": "whole",
    "issues": [],
    "frames": [
        {"time": 0, "arrays": {"mesh/1/faces": "aa", "camera/3": "bb"}},
        {"time": 1, "arrays": {"mesh/1/faces": "cc", "camera/3": "dd"}},
    ],
    "sounds": {
        "4": {
            "packets": 2,
            "start": 0,
            "sha256": "ee",
            "chunks": [
                {"start": 0, "packets": 1, "sha256": "e1"},
                {"start": 9, "packets": 1, "sha256": "e2"},
            ],
        }
    },
    "environment": {"5": {"light/0": "ff"}},
    "summary": {"frames": 2, "cameras": [3], "ended": True},
}
FAULTY = {**WHOLE, "status": "damaged", "issues": [{"issue": "FVV-3003", "offset": 96}]}


def changed(report, **fields):
    return {**json.loads(json.dumps(report)), **fields}


def test_the_same_agrees():
    assert describe_differences("valid", WHOLE, WHOLE, PARTS) == []
    assert describe_differences("faulty", FAULTY, FAULTY, PARTS) == []
    strings = changed(WHOLE, frames=[{**frame, "time": str(frame["time"])} for frame in WHOLE["frames"]])
    assert describe_differences("valid", WHOLE, strings, PARTS) == []


@pytest.mark.parametrize(
    "fields",
    [
        {"status": "damaged"},
        {"status": "fine"},
        {"issues": [{"issue": "FVV-1103", "offset": 5}]},
        {"frames": WHOLE["frames"][:1]},
        {"frames": WHOLE["frames"][::-1]},
        {"frames": WHOLE["frames"] + [{"time": 2, "arrays": {}}]},
        {"frames": [WHOLE["frames"][0], {"time": 1, "arrays": {"mesh/1/faces": "cc", "camera/3": "d0"}}]},
        {"frames": [WHOLE["frames"][0], {"time": 1, "arrays": {"mesh/1/faces": "cc"}}]},
        {
            "frames": [
                WHOLE["frames"][0],
                {"time": 1, "arrays": {**WHOLE["frames"][1]["arrays"], "mesh/2/faces": ""}},
            ]
        },
        {"sounds": {}},
        {"sounds": {"4": {"packets": 2, "start": 1, "sha256": "ee"}}},
        {"environment": {}},
        {"environment": {"5": {"light/0": "f0"}}},
        {"summary": {"frames": 3}},
        {"frames": None},
    ],
)
def test_differences_in_a_whole_stream(fields):
    assert describe_differences("valid", WHOLE, changed(WHOLE, **fields), PARTS)


def test_parts_that_are_not_claimed_are_not_compared():
    other = changed(
        WHOLE, frames=[{**f, "arrays": {**f["arrays"], "camera/3": "0"}} for f in WHOLE["frames"]], sounds={}
    )
    assert describe_differences("valid", WHOLE, other, frozenset(("mesh", "environment"))) == []


def test_show_prints_values_and_what_differs(tmp_path, capsys):
    assert command.main(["show", "mesh_raw_grid"]) == 1
    capsys.readouterr()
    name = next(c.name for c in cases.load(cases.default_folder(), ["valid/vector_delta_stencils"]))
    assert command.main(["show", name]) == 0
    assert "frame 0: camera" in (out := capsys.readouterr().out) or "mesh/1/lattice" in out
    assert command.main(["show", name, "--array", "mesh/1/faces", "--time", "0"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert (
        lines[1].startswith("mesh/1/faces at 0: ")
        and lines[2].startswith("  0: ")
        and len(lines[2].split()) == 4
    )
    from fvv_conformance.show import frames_of

    case = cases.load(cases.default_folder(), [name])[0]
    data = bytearray(dict(frames_of(case.content))[0]["mesh/1/faces"])
    own = tmp_path / "faces"
    own.write_bytes(data)
    given = ["show", name, "--array", "mesh/1/faces", "--time", "0", "--against", str(own)]
    assert command.main(given) == 0 and "0 of" in capsys.readouterr().out
    data[12] ^= 1
    own.write_bytes(data)
    assert command.main(given) == 1
    assert "1 of" in (out := capsys.readouterr().out) and "expected" in out
    assert command.main(["show", name, "--array", "mesh/9/faces"]) == 1
    assert "no whole frame has the array mesh/9/faces" in capsys.readouterr().err


def test_limits_of_readers_differ():
    """Clause 13 lets a reader take more than the reference library, and no more than the guaranteed limits."""
    faulty = changed(FAULTY, issues=[{"issue": "FVV-7001", "offset": 96}], limits=True)
    refused = changed(WHOLE, status="refused", issues=[{"issue": "FVV-7001", "offset": 9}], frames=[])
    assert describe_differences("faulty", faulty, faulty, PARTS) == []
    assert describe_differences("faulty", faulty, WHOLE, PARTS) == []
    assert describe_differences("faulty", changed(faulty, limits=False), WHOLE, PARTS)
    assert describe_differences("uncommon", changed(WHOLE, limits=True), refused, PARTS) == []
    assert describe_differences("uncommon", WHOLE, refused, PARTS)
    other = changed(refused, issues=[{"issue": "FVV-1103", "offset": 9}])
    assert describe_differences("uncommon", changed(WHOLE, limits=True), other, PARTS)


def test_faulty_streams():
    some = changed(FAULTY, frames=WHOLE["frames"][1:], sounds={}, environment={})
    assert describe_differences("faulty", FAULTY, some, PARTS) == []
    for fields in (
        {"status": "whole"},
        {"issues": []},
        {"issues": [{"issue": "FVV-3003", "offset": 97}]},
        {"issues": [{"issue": "FVV-3004", "offset": 96}]},
        {"issues": [{"issue": "FVV-1101", "offset": 0}, *FAULTY["issues"]]},
        {"frames": [{"time": 7, "arrays": {}}]},
        {"sounds": {"4": {"packets": 3, "start": 0, "sha256": "e0"}}},
    ):
        assert describe_differences("faulty", FAULTY, changed(FAULTY, **fields), PARTS), fields
    unchecked = changed(FAULTY, status="whole", issues=[])
    assert describe_differences("faulty", FAULTY, unchecked, PARTS - {"check"})
    assert describe_differences("faulty", {**FAULTY, "needs_check": True}, unchecked, PARTS - {"check"}) == []


EARLIER = {"5": {"light/0": "e1", "part/0/faces": "e2"}}


def verdict(report, parts=PARTS, kind="bit", others=()):
    environments = [EARLIER, WHOLE["environment"]]
    return judge(WHOLE, environments, report, damage.Damage("x", kind, b"", frozenset(others)), parts).outcome


def test_verdicts():
    assert verdict({**WHOLE, "status": "refused", "frames": [], "sounds": {}, "environment": {}}) == "refused"
    assert verdict(changed(FAULTY, frames=WHOLE["frames"][1:])) == "damaged"
    assert verdict(changed(FAULTY, frames=WHOLE["frames"][1:]), others=[0]) == "silent"
    wrong = [{"time": 0, "arrays": {"mesh/1/faces": "ab", "camera/3": "bb"}}]
    assert verdict(changed(FAULTY, frames=wrong)) == "silent"
    assert verdict(WHOLE) == "silent"  # it checks, and noticed nothing
    assert verdict(WHOLE, PARTS - {"check"}) == "unaffected"
    cut = changed(WHOLE, frames=WHOLE["frames"][:1], sounds={}, summary={"ended": False})
    assert verdict(cut, kind="cut") == "unaffected"
    assert verdict({**cut, "frames": WHOLE["frames"][1:]}, kind="cut") == "silent"
    assert verdict({**cut, "summary": {"ended": True}}, PARTS - {"check"}) == "silent"
    one_chunk = {"packets": 1, "start": 9, "sha256": "e2", "chunks": WHOLE["sounds"]["4"]["chunks"][1:]}
    assert verdict(changed(FAULTY, sounds={"4": one_chunk})) == "damaged"
    assert (
        verdict(changed(FAULTY, sounds={"4": {**one_chunk, "chunks": [{**one_chunk, "sha256": "0"}]}}))
        == "silent"
    )
    assert verdict(changed(FAULTY, environment=EARLIER)) == "damaged"
    assert verdict(changed(FAULTY, environment={"5": {"light/0": "e1"}})) == "silent"
    assert verdict("no answer") == verdict({}) == "failed"


PROGRAM = """
import json, sys, time
for line in sys.stdin:
    request = json.loads(line)
    if request["op"] == "hello":
        print(json.dumps({"protocol": 1, "name": "fake", "parts": ["mesh"]}), flush=True)
    elif request["op"] == "decode":
        what = request["path"]
        if what == "die":
            print("why it died", file=sys.stderr)
            sys.exit(3)
        if what == "hang":
            time.sleep(60)
        if what == "nonsense":
            print("what?", flush=True)
        elif what == "other":
            print(json.dumps({"id": -1}), flush=True)
        elif what == "error":
            print(json.dumps({"id": request["id"], "error": "cannot be opened"}), flush=True)
        else:
            print(json.dumps({"id": request["id"], "status": what, "frames": []}), flush=True)
"""


def fake(tmp_path, program=PROGRAM):
    path = tmp_path / "fake.py"
    path.write_text(textwrap.dedent(program))
    return f"{sys.executable} {path}"


def test_a_decoder_that_fails_is_started_again(tmp_path):
    wanted = ["a", "die", "b", "nonsense", "c", "hang", "d", "other", "error", "e", *["f"] * 40, "die", "g"]
    with Decoder(fake(tmp_path), timeout=2) as decoder:
        found = list(decoder.decode_all({"path": path} for path in wanted))
        assert decoder.starts == 6
    answers = dict(zip(wanted, found))
    assert [one["status"] for one in found if isinstance(one, dict)] == [
        "a",
        "b",
        "c",
        "d",
        "e",
        *["f"] * 40,
        "g",
    ]
    assert answers["die"] == "ended with exit code 3: why it died"
    assert answers["hang"] == "no answer within 2 s"
    assert answers["error"] == "error: cannot be opened"
    assert "expected a JSON object" in answers["nonsense"] and "expected" in answers["other"]


def test_a_former_word_is_read_as_the_present_one(tmp_path, capsys):
    program = """
        import json, sys
        for line in sys.stdin:
            if json.loads(line)["op"] == "hello":
                answer = {"protocol": 1, "name": "old", "parts": ["mesh", "background"]}
            else:
                answer = {"id": json.loads(line)["id"], "background": {"5": {}}}
            print(json.dumps(answer), flush=True)
    """
    with Decoder(fake(tmp_path, program)) as decoder:
        assert decoder.parts == {"mesh", "environment"}
        assert list(decoder.decode_all([{"path": "a"}])) == [{"id": 0, "environment": {"5": {}}}]
    assert capsys.readouterr().err == "old: background is now environment\n"


def test_what_is_no_decoder(tmp_path):
    for program in ("true", "absent-program", fake(tmp_path, "print('hello')")):
        with pytest.raises(DecoderError):
            Decoder(program)


def write_case(folder, name, content, expected):
    path = folder / name
    path.mkdir(parents=True)
    (path / "input.fvv").write_bytes(content)
    about = {"title": "</script><b>", "rules": ["FVV-1001"], "clauses": ["3"]}
    (path / "expected.json").write_text(json.dumps(about | expected))


def test_outputs_name_disagreements(tmp_path, capsys):
    write_case(tmp_path / "cases", "valid/one", b"", {**WHOLE, "frames": []})
    outputs = {name: tmp_path / name for name in ("json", "junit", "html")}
    given = ["run", "--decoder", fake(tmp_path), "--cases", str(tmp_path / "cases")]
    given += [word for name, path in outputs.items() for word in (f"--{name}", str(path))]
    assert command.main(given) == 1
    assert "fake: valid/one: status is" in capsys.readouterr().out
    result = json.loads(outputs["json"].read_text())
    assert result["figures"]["conformance.agreement_percent"] == 0
    (failure,) = ElementTree.parse(outputs["junit"]).iter("failure")
    assert "status is" in failure.get("message")
    page = outputs["html"].read_text()
    assert "\\u003c/script>" in page and "/*RESULT*/ null" not in page and page.count("</script>") == 1


def test_usage(tmp_path, capsys):
    with pytest.raises(SystemExit) as stop:
        command.main(["run"])
    assert stop.value.code == 2
    assert command.main(["list", "--cases", str(tmp_path)]) == 1
    write_case(tmp_path, "faulty/half", b"", {})
    (tmp_path / "faulty/half/expected.json").write_text("{")
    assert command.main(["list", "--cases", str(tmp_path)]) == 1
    assert "expected.json" in capsys.readouterr().err


def test_damages_are_always_the_same():
    stream = next(case for case in cases.load(cases.default_folder()) if case.tier == "valid").content
    first = list(damage.sampled(stream, 50, "seed"))
    assert first == list(damage.sampled(stream, 50, "seed")) and len(first) >= 50
    assert all(one.content != stream for one in first)
    every = list(damage.every(stream[:100], 0, 1))
    assert len({one.content for one in every if one.kind in ("cut", "bit")}) == 900
