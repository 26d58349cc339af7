"""Every public name is there, typed and documented."""

from __future__ import annotations

import ast
import importlib.metadata
import inspect
import subprocess
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest

import iridesce as ir
from conftest import ROOT
from iridesce import _core

STUB = ast.parse((ROOT / "python" / "iridesce" / "_core.pyi").read_text())


def is_public(name: str) -> bool:
    return not name.startswith("_")


# --- _core.pyi says what _core is


def stub_members(body: list[ast.stmt]) -> dict[str, ast.stmt]:
    """The names that a stub's body defines (imports are not definitions)."""
    members: dict[str, ast.stmt] = {}
    for statement in body:
        if isinstance(statement, ast.FunctionDef | ast.ClassDef):
            members[statement.name] = statement
        elif isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
            members[statement.target.id] = statement
    return members


def parameters(function: ast.FunctionDef) -> list[str]:
    """The names a stub's function takes, `self` and `cls` left out."""
    arguments = function.args
    names = [a.arg for a in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]]
    return [name for name in names if name not in {"self", "cls"}]


def test_stub_has_the_names_of_core() -> None:
    names = {name for name in dir(_core) if is_public(name)} | {"__version__"}
    assert set(stub_members(STUB.body)) - {"_"} == names


def test_stub_classes_have_the_members_of_core() -> None:
    for name, statement in stub_members(STUB.body).items():
        if isinstance(statement, ast.ClassDef):
            stub = {member for member in stub_members(statement.body) if is_public(member)}
            assert stub == {member for member in vars(getattr(_core, name)) if is_public(member)}, name


def test_stub_functions_take_what_core_takes() -> None:
    compared = 0
    for name, statement in stub_members(STUB.body).items():
        owner = getattr(_core, name)
        body = statement.body if isinstance(statement, ast.ClassDef) else [statement]
        for member, function in stub_members(body).items():
            target = getattr(owner, member) if isinstance(statement, ast.ClassDef) else owner
            if not isinstance(function, ast.FunctionDef) or member.startswith("__") or not callable(target):
                continue
            names = [p for p in inspect.signature(target).parameters if p != "self"]
            assert parameters(function) == names, f"{name}.{member}" if target is not owner else name
            compared += 1
    assert compared > 0


# --- public Python


def modules() -> list[ModuleType]:
    """The modules a user may name: the package itself and those it exports."""
    return [ir, *(value for name in ir.__all__ if inspect.ismodule(value := getattr(ir, name)))]


def public_names(module: ModuleType) -> list[str]:
    names = getattr(module, "__all__", None)
    if names is None:
        names = [n for n, v in vars(module).items() if is_public(n) and getattr(v, "__module__", "") == module.__name__]
    return sorted(names)


def public_objects() -> Iterator[tuple[str, Any]]:
    for module in modules():
        for name in public_names(module):
            value = getattr(module, name)
            if inspect.ismodule(value):
                continue
            yield f"{module.__name__}.{name}", value
            if inspect.isclass(value):
                # What it has of its own or from bases of ours.
                owners = [owner for owner in value.__mro__ if owner.__module__.startswith("iridesce.")]
                for member, raw in [pair for owner in reversed(owners) for pair in vars(owner).items()]:
                    if is_public(member):
                        function = raw.__func__ if isinstance(raw, classmethod | staticmethod) else raw
                        yield f"{module.__name__}.{name}.{member}", function


OBJECTS = dict(public_objects())


@pytest.mark.parametrize("name", sorted(OBJECTS))
def test_public_name_is_documented(name: str) -> None:
    value = OBJECTS[name]
    is_function = inspect.isroutine(value)
    if not (is_function or inspect.isclass(value) or isinstance(value, property)):
        return  # a constant, or a field of a dataclass, explained where its class is
    text = inspect.getdoc(value) or ""
    assert text, f"{name} has no docstring"
    if not isinstance(value, property):  # the example of its class shows a property
        assert ">>>" in text, f"the docstring of {name} shows no example"
    if not is_function:
        return
    assert len(text) > 40, f"the docstring of {name} says next to nothing"
    signature = inspect.signature(value)
    if signature.return_annotation != "None":
        assert "Returns" in text, f"the docstring of {name} does not say what it returns"
    if set(signature.parameters) - {"self", "cls"}:  # who takes nothing refuses nothing
        assert "Raises" in text, f"the docstring of {name} does not say what it raises"


def test_documented_names_include_the_promised_ones() -> None:
    promised = (
        "Medium Medium.from_file Medium.index media Layer Stack Stack.reflectance Stack.transmittance"
        " ColorTable ColorTable.color ColorTable.load ColorTable.save"
        " Stack.absorptance Stack.layer_absorptance Stack.amplitudes Stack.ellipsometry Stack.reversed Stack.color"
        " color.spectrum_to_xyz color.convert color.delta_e color.illuminant color.dias1991"
        " Scene Scene.load Scene.to_dict Scene.with_value render Image Image.rgb Image.save SceneError ResourceError"
        " plot.locus plot.strip plot.chart plot.spectrum plot.medium"
    )
    names = {name.removeprefix("iridesce.") for name in OBJECTS}
    assert set(promised.split()) - names == set()


@pytest.mark.parametrize("name", sorted(n for n, v in OBJECTS.items() if inspect.isroutine(v)))
def test_public_function_has_type_hints(name: str) -> None:
    signature = inspect.signature(OBJECTS[name])
    untyped = [
        p.name for p in signature.parameters.values() if p.annotation is p.empty and p.name not in {"self", "cls"}
    ]
    assert untyped == []
    assert signature.return_annotation is not signature.empty, "the return type is not stated"


def test_completion_offers_the_public_names_and_no_others() -> None:
    """What a notebook offers after `ir.color.` and the tab key: no numpy, no helpers."""
    for module in modules()[1:]:
        assert dir(module) == sorted(module.__all__)
    assert {"color", "plot", "thickness", "Stack", "render"} <= set(dir(ir))
    # Editors do not run the package: they read the imports under TYPE_CHECKING.
    tree = ast.parse((ROOT / "python" / "iridesce" / "__init__.py").read_text())
    shown = {
        alias.asname
        for statement in ast.walk(tree)
        if isinstance(statement, ast.ImportFrom) and statement.level == 0 and statement.module != "typing"
        for alias in statement.names
    }
    assert shown - {None} == {*ir.__all__, "__version__"}


def test_package_is_typed_and_lists_its_names() -> None:
    assert (ROOT / "python" / "iridesce" / "py.typed").is_file()
    assert set(ir.__all__) <= set(dir(ir))
    assert importlib.metadata.version("iridesce") == ir.__version__ == _core.__version__
    with pytest.raises(AttributeError, match="no attribute 'Stak'"):
        ir.Stak  # noqa: B018


def test_import_is_light() -> None:
    """Starting up must not pay for numpy or matplotlib: `iridesce --help` and small scripts start at once."""
    code = "import sys, iridesce; print(sorted({'numpy', 'matplotlib', 'typer', 'rich'} & set(sys.modules)))"
    finished = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert finished.stdout.strip() == "[]"
