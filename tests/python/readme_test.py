"""The examples of engine/python/README.md run as they stand, and the first prints what the page says."""

import contextlib
import importlib.util
import io
import re

import pytest
from conftest import SOURCE

TEXT = (SOURCE / "engine/python/README.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^```python\n(.*?)^```", TEXT, re.M | re.S)
OUTPUTS = re.findall(r"^```text\n(.*?)^```", TEXT, re.M | re.S)


def test_examples_one_after_the_other(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert len(EXAMPLES) > 4
    names, printed = {}, []
    for example in EXAMPLES:
        if "handhold import plan" in example and not importlib.util.find_spec("handhold._plan"):
            continue
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(example, "README.md", "exec"), names)
        printed.append(out.getvalue())
    assert printed[0] == OUTPUTS[0]
    tracked = [line for line in printed[3].splitlines() if line.startswith("1 ")]
    assert tracked, "the rod is not followed"
    if len(printed) == len(EXAMPLES):
        assert len(names["made"].grasps) == 1, names["made"]


def test_the_error_is_the_one_it_shows():
    import handhold

    with pytest.raises(ValueError) as error:
        handhold.localize([[0.0, 0.0, 1.0]], radiuss=0.03)
    assert OUTPUTS[1].strip() == str(error.value)


def test_every_public_name_is_there():
    import handhold

    for name in handhold.__all__:
        # Types of results are told of by what has them.
        if not isinstance(getattr(handhold, name), type) or name in ("Localizer", "Tracker"):
            assert name.strip("_") in TEXT, f"README.md does not mention {name}"


@pytest.mark.parametrize("kind", ["handles", "affordances"])
def test_every_field_is_there(kind):
    import handhold

    (row,) = re.findall(rf"^\| `result.{kind}` \| (.*) \|$", TEXT, re.M)
    type_of = {"handles": handhold.Handles, "affordances": handhold.Affordances}[kind]
    fields = [name for name, value in vars(type_of).items() if isinstance(value, property)]
    assert sorted(re.findall(r"`(\w+)`", row)) == sorted(fields)
