"""conformance/mutants.py: which tokens are changed, and that a changed decoder is judged by the cases."""

import json

import mutants
import pytest
from fvv_conformance.cases import default_folder, load

SYMBOLS = mutants.PACKAGE / "decode/draco_symbols.py"


@pytest.fixture(scope="module")
def every():
    return list(mutants.mutants_of(SYMBOLS))


@pytest.fixture(scope="module")
def suite():
    suite = mutants.Suite(load(default_folder(), ["mesh_draco_t*"]))
    suite.measure()
    return suite


def the(every, source, old):
    return next(m for m in every if m.source.startswith(source) and m.old == old)


def test_numbers_operators_and_words_change_and_texts_do_not(every):
    assert len(every) > 100
    for mutant in every:
        text = SYMBOLS.read_text()
        changed = mutants.mutated(mutant, text)
        assert len(changed.splitlines()) == len(text.splitlines())
        assert changed != text
        compile(changed, mutant.file, "exec")
    assert {"<", "+", "<<", "1"} <= {mutant.old for mutant in every}
    assert not [m for m in every if m.source.startswith(('"""', "from", "import"))]
    assert mutants.numbers("0x10") == ["17", "15"]
    assert mutants.numbers("0") == ["1"]


def judged(suite, mutant):
    return next(found for _, found in mutants.judge(suite, [mutant], 1, lambda: None))


def test_a_case_kills_what_it_shows_and_goes_first_then(suite, every):
    mutant = the(every, "self.base = 4 << self.bits", "4")
    name, difference = judged(suite, mutant)
    assert name in suite.cases
    assert difference
    assert suite.order(mutant)[0] == name


def test_what_no_case_shows_survives(suite, every):
    # None of the cases has an alphabet of 18 bits.
    mutant = the(every, "demand(1 <= bits <= 18", "18")
    assert suite.order(mutant)
    assert judged(suite, mutant) is None


def test_a_decoder_that_does_not_compile_is_killed(suite, every):
    broken = every[0]._replace(new="(", old="")
    assert judged(suite, broken)[1] == "SyntaxError"


def test_rows_of_equivalent_mutants_are_of_the_decoder_of_today():
    found = {mutant.key() for path in mutants.PACKAGE.rglob("*.py") for mutant in mutants.mutants_of(path)}
    rows = json.loads(mutants.EQUIVALENT.read_text())["equivalent"]
    assert [row for row in rows if (row["file"], row["line"], row["token"], row["to"]) not in found] == []
    assert all(len(row["reason"]) > 10 for row in rows)
