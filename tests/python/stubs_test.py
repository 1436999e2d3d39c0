"""The type stubs say what the module has: every public name, every signature, both ways."""

import ast
import importlib.util
import inspect
import pathlib

import pytest

import handhold

FOLDER = pathlib.Path(handhold.__file__).parent
MODULES = ["handhold", "handhold.plan"] if importlib.util.find_spec("handhold._plan") else ["handhold"]
# What Python itself puts into a class, and what needs no stub.
OF_PYTHON = {"__doc__", "__module__", "__new__", "__repr__", "__init__", "__dict__", "__weakref__", "__slotnames__"}


def stub_of(module):
    name = module.__name__.replace("handhold", "", 1).lstrip(".") or "__init__"
    return ast.parse((FOLDER / f"{name}.pyi").read_text())


def is_public(name):
    return not name.startswith("_") or name == "__version__"


def signature(function):
    """Names, kinds and defaults of a function in a stub."""
    kinds, parameters = inspect.Parameter, []
    arguments = function.args
    assert not arguments.posonlyargs and not arguments.vararg and not arguments.kwarg
    defaults = [kinds.empty] * (len(arguments.args) - len(arguments.defaults)) + arguments.defaults
    rows = [(a, d, kinds.POSITIONAL_OR_KEYWORD) for a, d in zip(arguments.args, defaults)]
    rows += [(a, d or kinds.empty, kinds.KEYWORD_ONLY) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    for argument, default, kind in rows:
        value = default if default is kinds.empty else ast.literal_eval(default)
        assert argument.annotation or argument.arg == "self", f"{function.name}: {argument.arg} has no type"
        parameters.append((argument.arg, kind, value))
    assert function.returns, f"{function.name} has no type"
    return parameters


def real_signature(function):
    empty = inspect.Parameter.empty
    # Python functions may have types of their own; their defaults count.
    return [(p.name, p.kind, p.default if p.default is not empty else empty)
            for p in inspect.signature(function).parameters.values()]


def members(node):
    """Of a class in a stub: its methods and properties by name; overloads once."""
    found = {}
    for item in node.body:
        if isinstance(item, ast.FunctionDef):
            found[item.name] = item
        elif isinstance(item, ast.AnnAssign):
            found[item.target.id] = item
    return found


def is_property(node):
    return any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list)


@pytest.fixture(params=MODULES)
def module(request):
    return importlib.import_module(request.param)


def stub_names(stub):
    names = {node.name: node for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    names.update({node.target.id: node for node in stub.body if isinstance(node, ast.AnnAssign)})
    return {name: node for name, node in names.items() if is_public(name)}


def test_the_same_public_names(module):
    assert sorted(stub_names(stub_of(module))) == sorted(module.__all__)
    assert len(set(module.__all__)) == len(module.__all__)
    submodules = {"plan"}
    hidden = {name for name in vars(module) if is_public(name)} - set(module.__all__) - submodules
    assert hidden == set()


def test_functions(module):
    for name, node in stub_names(stub_of(module)).items():
        if isinstance(node, ast.FunctionDef):
            assert signature(node) == real_signature(getattr(module, name)), name
            assert inspect.getdoc(getattr(module, name)), f"{name} has no docstring"


def test_classes(module):
    for name, node in stub_names(stub_of(module)).items():
        if not isinstance(node, ast.ClassDef):
            continue
        real, declared = getattr(module, name), members(node)
        assert inspect.getdoc(real), f"{name} has no docstring"
        assert real.__module__ == module.__name__, name
        if issubclass(real, tuple):  # a NamedTuple
            assert tuple(declared) == real._fields
            continue
        own = {member for member in vars(real) if member not in OF_PYTHON}
        assert own == set(declared) - {"__init__"}, name
        if "__init__" in declared:
            assert signature(declared["__init__"])[1:] == real_signature(real), name
        else:
            with pytest.raises(TypeError, match="No constructor defined"):
                real()
        for member, item in declared.items():
            here = f"{name}.{member}"
            if member.startswith("__"):
                continue
            attribute = inspect.getattr_static(real, member)
            assert isinstance(attribute, property) == is_property(item), here
            assert inspect.getdoc(getattr(real, member)), f"{here} has no docstring"
            static = any(isinstance(d, ast.Name) and d.id == "staticmethod" for d in item.decorator_list)
            assert static == isinstance(attribute, staticmethod), here
            if not is_property(item):
                assert signature(item) == real_signature(getattr(real, member)), here


def test_options_are_those_of_the_library():
    stub = stub_names(stub_of(handhold))
    declared = [name for name, _, _ in signature(stub["options"])]
    assert declared == ["hand", "config", *handhold.options()]
    defaults = {name: value for name, _, value in signature(stub["options"])}
    assert {name: defaults[name] for name in handhold.options()} == handhold.options()


def test_dictionaries_have_these_keys():
    stub = stub_of(handhold)
    result = handhold.localize([[0.0, 0.0, 0.0]])
    for node in stub.body:
        if isinstance(node, ast.ClassDef) and node.name in ("_Funnel", "_Times"):
            real = {"_Funnel": result.funnel, "_Times": result.times_ms}[node.name]
            assert list(members(node)) == list(real)
            types = {item.target.id: item.annotation.id for item in node.body}
            assert types == {name: type(value).__name__ for name, value in real.items()}


@pytest.mark.parametrize(
    "alias, option",
    [
        ("_Method", "method"),
        ("_Strategy", "strategy"),
        ("_Axis", "axis"),
        ("_Index", "index"),
        ("_Backend", "backend"),
    ],
)
def test_names_of_choices(alias, option):
    (node,) = [n for n in stub_of(handhold).body if isinstance(n, ast.Assign) and n.targets[0].id == alias]
    with pytest.raises(ValueError) as error:
        handhold.options(**{option: "nothing of that kind"})
    literal = ", ".join(f"'{element.value}'" for element in node.value.slice.elts)
    assert str(error.value).endswith(f"must be one of {literal}")


def test_the_package_says_that_it_has_types():
    assert (FOLDER / "py.typed").exists()
