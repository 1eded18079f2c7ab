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


def keywords(*names):
    """The keywords that types are written for."""
    dicts = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef)}
    return [line.target.id for name in names for line in dicts[name].body]


def test_every_setting_of_a_mixture_has_a_type_and_a_text():
    """And each is one that the filter knows."""
    for name in keywords("_Plausible", "_MixtureSettings"):
        assert name in scphd.Filter.__doc__, name
        others = {"extraction": "confirmed", "informed_rounds": 1, "max_components": 9, "confirming_detections": 2.0}
        scphd.Filter(scphd.Unicycle(), **{name: others.get(name, 0.5)})


def test_every_setting_of_a_joint_map_has_a_type_and_a_text():
    """They are those of the list that C and the firmware have too: what is added there shows here."""
    known = {name for name, *_ in scphd._native._joint_settings()}
    assert known == set(keywords("_Plausible", "_JointSettings"))
    assert all(f"\n{name} : " in scphd.JointFilter.__doc__ for name in known)
