"""The sources of the package as they are in the repository: their imports, and their version."""

import ast
import graphlib
import pathlib
import re
import tomllib
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
CLIENT = REPOSITORY / "clients/python"


class ImportsOfModule(ast.NodeVisitor):
    """Collects the modules among `known` that a source imports when it runs, in functions too."""

    def __init__(self, known: set[str]):
        self.known = known
        self.found: set[str] = set()

    def visit_If(self, node: ast.If) -> None:
        if ast.unparse(node.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}:
            for other in node.orelse:
                self.visit(other)
        else:
            self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        self.found |= {alias.name for alias in node.names} & self.known

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        assert node.level == 0, "the package imports by full names"
        for alias in node.names:
            module = f"{node.module}.{alias.name}"  # as in `from cwm import arrays`
            self.found |= {module if module in self.known else node.module} & self.known


def imports(sources: dict[str, str]) -> dict[str, set[str]]:
    """The modules that each module imports, of those whose sources are given by name."""
    found = {}
    for name, source in sources.items():
        visitor = ImportsOfModule(set(sources))
        visitor.visit(ast.parse(source))
        found[name] = visitor.found
    return found


def circle(sources: dict[str, str]) -> list[str]:
    """Modules that import each other in turn, the first one again at the end; [] if none do."""
    try:
        graphlib.TopologicalSorter(imports(sources)).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


def sources_of_package() -> dict[str, str]:
    return {
        "cwm" if path.stem == "__init__" else f"cwm.{path.stem}": path.read_text()
        for path in (CLIENT / "cwm").glob("*.py")
    }


class Imports(unittest.TestCase):
    def test_of_no_module_lead_back_to_it(self):
        sources = sources_of_package()
        self.assertIn("cwm.view", imports(sources)["cwm.world"])
        self.assertEqual(circle(sources), [])

    def test_that_lead_back_are_found_in_functions_but_not_if_only_for_types(self):
        view = "def stream():\n    from cwm.stream import QueryStream"
        stream = "import numpy\nfrom cwm import view"
        self.assertCountEqual(
            set(circle({"cwm.view": view, "cwm.stream": stream})), ["cwm.view", "cwm.stream"]
        )
        self.assertEqual(circle({"cwm": "", "cwm.view": "from cwm import pose"}), [])
        self.assertCountEqual(
            set(circle({"cwm": "import cwm.view", "cwm.view": "from cwm import pose"})),
            ["cwm", "cwm.view"],
        )
        typed = "if TYPE_CHECKING:\n    from cwm.stream import QueryStream"
        self.assertEqual(circle({"cwm.view": typed, "cwm.stream": stream}), [])


class Version(unittest.TestCase):
    def test_is_that_of_the_project(self):
        project = re.search(
            r"^project\(cwm VERSION ([0-9.]+)", (REPOSITORY / "CMakeLists.txt").read_text(), re.M
        )
        metadata = tomllib.loads((CLIENT / "pyproject.toml").read_text())["project"]
        self.assertEqual(metadata["version"], project[1])
