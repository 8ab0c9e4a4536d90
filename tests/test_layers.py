"""The layers: which folder may import which, held by reading every import of the package."""

import ast
from pathlib import Path

import pytest

import gnsslab

PACKAGE = Path(gnsslab.__file__).parent
LAYERS = ("core", "gnss", "data", "simulate", "systems", "figures", "labs", "reproduce", "teaching", "cli")
NOT_YET = set()  # layers that come with a later lesson; a folder of that name must be taken off this list
ABOVE_ALL = {"", "__main__"}  # the public door and `python -m gnsslab`
KEPT_IN = {"matplotlib": {"figures"}, "marimo": {"teaching"}, "typer": {"cli"}, "rich": {"cli"}, "pooch": {"data"}, "starlette": {"teaching"}}


def module_of(path):
    """Return the dotted name of a source file: gnsslab.gnss.times, gnsslab.core for core/__init__.py."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(path, modules):
    """Return the modules that a file imports, each with its line, wherever the import stands."""
    found = []
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found += [(alias.name, node.lineno) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: a relative import; write the whole name"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found += [(name if name in modules else node.module, node.lineno) for name in names]
    return found


FILES = {module_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}
IMPORTS = {module: imports_of(path, FILES) for module, path in FILES.items()}
INNER = [(a, b, line) for a, found in IMPORTS.items() for b, line in found if b.split(".")[0] == "gnsslab"]


def layer_of(module):
    """Return the layer of a module: `gnss` of gnsslab.gnss.times, nothing of gnsslab itself."""
    return [*module.split("."), ""][1]


def test_there_is_something_to_check():
    assert len(FILES) > 30
    assert len(INNER) > 60
    assert {layer_of(module) for module in FILES} - ABOVE_ALL == set(LAYERS) - NOT_YET


def test_imports_go_one_way():
    upward = [
        f"{a}:{line} imports {b}"
        for a, b, line in INNER
        if layer_of(a) not in ABOVE_ALL and layer_of(b) and LAYERS.index(layer_of(b)) > LAYERS.index(layer_of(a))
    ]
    assert upward == []


def test_every_import_of_ours_leads_somewhere():
    assert [f"{a}:{line} imports {b}" for a, b, line in INNER if b not in FILES] == []


def test_no_import_leads_back_to_where_it_came_from():
    reached = {module: {b for a, b, _ in INNER if a == module and b != module and b != "gnsslab"} for module in FILES}
    for _ in FILES:  # the transitive closure
        reached = {module: near.union(*(reached.get(b, set()) for b in near)) for module, near in reached.items()}
    assert sorted(module for module, all_ in reached.items() if module in all_) == []


@pytest.mark.parametrize(("library", "layers"), KEPT_IN.items())
def test_library_is_imported_in_its_own_layer_only(library, layers):
    users = {layer_of(module) for module, found in IMPORTS.items() for name, _ in found if name.split(".")[0] == library}
    assert users, f"nothing imports {library}: then it should not be a dependency"
    assert users <= layers


def test_the_public_names_have_a_home():
    homes = {home for home in gnsslab._HOME_OF.values()}
    assert homes <= set(FILES)
    for name in gnsslab.__all__:
        assert getattr(gnsslab, name) is not None
