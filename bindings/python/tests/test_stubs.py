"""The types that editors see are of what is there."""

import ast
import importlib.resources
import inspect

import pytest

import scphd

STUBS = ast.parse((importlib.resources.files("scphd") / "_native.pyi").read_text())
CLASSES = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")}


def test_every_class_has_types():
    assert set(CLASSES) == set(scphd.__all__) - {"logs"}


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_every_method_has_types(name):
    stubs = {node.name: node for node in CLASSES[name].body if isinstance(node, ast.FunctionDef)}
    there = getattr(scphd, name)
    public = set() if issubclass(there, Exception) else {one for one in dir(there) if not one.startswith("_")}
    assert public == {one for one in stubs if not one.startswith("_")}
    for method in public:
        if callable(getattr(there, method)):
            parameters = list(inspect.signature(getattr(there, method)).parameters)
            arguments = stubs[method].args
            assert parameters == [one.arg for one in arguments.args + arguments.kwonlyargs], method


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_every_keyword_has_a_type(name):
    new = next((node for node in CLASSES[name].body if getattr(node, "name", "") == "__new__"), None)
    if new is not None:
        parameters = inspect.signature(getattr(scphd, name)).parameters
        arguments = [one.arg for one in new.args.args[1:] + new.args.kwonlyargs]
        assert [one for one in parameters if one != "settings"] == arguments


@pytest.mark.parametrize(("filter_class", "settings"), [("Filter", "_MixtureSettings"), ("JointFilter", "_JointSettings")])
def test_every_setting_has_a_type_and_a_text(filter_class, settings):
    """And each is one that the filter knows."""
    dicts = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef)}
    names = {line.target.id: line for one in ("_Plausible", settings) for line in dicts[one].body}
    there = getattr(scphd, filter_class)
    for name in names:
        assert name in there.__doc__, name
        others = {"extraction": "confirmed", "informed_rounds": 1, "max_components": 9, "confirming_detections": 2.0}
        there(scphd.Unicycle(), **{name: others.get(name, 0.5)})
