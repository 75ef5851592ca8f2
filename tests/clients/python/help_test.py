"""What `help(cwm)` and `help(cwm.NAME)` show to those who have just found the package."""

import ast
import inspect
import pathlib
import pydoc
import re
import textwrap

import numpy as np

import cwm
from server_case import ServerCase

# A class of 30 methods with the meaning of their arguments; with all inherited methods it was 10
# 000 lines.
MAX_LINES = 400
# Words that a numpy user need not know.
MESSAGES = re.compile(r"_pb2|[Pp]rotobuf|FromString|SerializeTo")


def shown(obj: object) -> str:
    return pydoc.plain(pydoc.render_doc(obj))


def names_of_package() -> list[str]:
    """All that the package imports for its users."""
    tree = ast.parse(pathlib.Path(cwm.__file__).read_text())
    return [
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("cwm.")
        for alias in node.names
    ]


def names_for_checkers() -> list[str]:
    """`__all__` as those read it who run nothing."""
    lists = []
    for node in ast.walk(ast.parse(pathlib.Path(cwm.__file__).read_text())):
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        if isinstance(target, ast.Name) and target.id == "__all__":
            lists += ast.literal_eval(node.value)
    return lists


class Help(ServerCase):
    def test_of_the_package_is_short_and_begins_with_an_example(self):
        text = shown(cwm)
        lines = text.splitlines()
        self.assertLess(len(lines), MAX_LINES)
        self.assertIn("import cwm", "\n".join(lines[:8]))
        for word in ["class World", "connect(", "ingest(self", "check(self", "distance(self"]:
            self.assertIn(word, text)

    def test_shows_no_messages(self):
        for obj in [cwm, *(getattr(cwm, name) for name in names_of_package())]:
            with self.subTest(obj):
                self.assertEqual(MESSAGES.findall(shown(obj)), [])

    def test_lists_every_class_that_is_no_word_or_error(self):
        listed = set(re.findall(r"\w+", cwm.__doc__))
        self.assertEqual(
            {
                name
                for name in names_of_package()
                if inspect.isclass(getattr(cwm, name))
                and not hasattr(getattr(cwm, name), "__members__")
                and not issubclass(getattr(cwm, name), Exception)
            }
            - listed,
            set(),
        )
        table = cwm.__doc__[cwm.__doc__.index("begin ") :]
        for name in re.findall(r"\b[A-Z]\w+", table):
            if name not in {"Words"}:
                self.assertTrue(hasattr(cwm, name), name)

    def test_example_runs_as_it_is_printed(self):
        code = textwrap.dedent(cwm.__doc__.split("\n\n")[1])
        self.assertLessEqual(len(code.splitlines()), 5)
        xy = np.stack(np.meshgrid(np.linspace(-0.4, 0.4, 160), np.linspace(-0.3, 0.3, 120)), -1)
        points = np.concatenate([xy, np.ones((*xy.shape[:2], 1))], -1)
        poses = np.tile(np.eye(4), (3, 1, 1))
        self.world.put("ball", cwm.Sphere(0.1), cwm.pose([0, 0, 3]))
        here = {"points": points, "poses": poses}
        address, world = self.running.address, self.world.name
        exec(code.replace("cwm.connect()", f"cwm.connect({address!r}, {world!r})"), here)
        self.assertEqual(here["answer"].distance_m.shape[0], 3)
        self.assertTrue(np.isfinite(here["answer"].distance_m).all())


class Names(ServerCase):
    def test_for_checkers_of_types_are_all_there_are(self):
        self.assertEqual(sorted(names_for_checkers()), sorted(names_of_package()))

    def test_taken_by_a_star_hide_none_of_the_users_own(self):
        taken: dict = {}
        exec("from cwm import *", taken)
        self.assertEqual(set(taken) - {"__builtins__"}, {"World", "connect", "pose"})
