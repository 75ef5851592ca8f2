"""What `help(cwm)` and `help(cwm.NAME)` show to those who have just found the package."""

import ast
import dataclasses
import enum
import html.parser
import inspect
import pathlib
import pydoc
import re
import textwrap
import typing
import unittest

import numpy as np
import numpy.typing  # for the annotations of the package

import cwm
from cwm import enums
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


def has_own_docstring(cls: type) -> bool:
    """Whether somebody wrote it: dataclasses and enums are given one otherwise."""
    text = vars(cls).get("__doc__") or ""
    given = text.startswith(f"{cls.__name__}(") or text == "An enumeration."
    return bool(text) and not given


def documented_aliases() -> set[str]:
    """Names of modules that a docstring follows, as those of types have it."""
    found = set()
    for path in pathlib.Path(cwm.__file__).parent.glob("*.py"):
        body = ast.parse(path.read_text()).body
        for node, after in zip(body, body[1:]):
            is_text = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            if isinstance(node, ast.Assign) and is_text:
                found |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return found


def public_functions(cls: type) -> list[tuple[str, typing.Callable]]:
    """Methods and properties that the class itself defines."""
    found = []
    for name, value in vars(cls).items():
        if name.startswith("_"):
            continue
        if isinstance(value, property):
            found.append((name, value.fget))
        elif isinstance(value, (classmethod, staticmethod)):
            found.append((name, value.__func__))
        elif inspect.isfunction(value):
            found.append((name, value))
    return found


def choices(annotation: object) -> tuple[set[type], set[str], bool]:
    """The enums, the words and whether any text at all that an annotation allows."""
    if isinstance(annotation, type) and issubclass(annotation, enum.Enum):
        return {annotation}, set(), False
    if annotation is str:
        return set(), set(), True
    if typing.get_origin(annotation) is typing.Literal:
        return set(), {arg for arg in typing.get_args(annotation) if isinstance(arg, str)}, False
    kinds: set[type] = set()
    words: set[str] = set()
    is_any = False
    for argument in typing.get_args(annotation):
        more_kinds, more_words, any_text = choices(argument)
        kinds, words, is_any = kinds | more_kinds, words | more_words, is_any or any_text
    return kinds, words, is_any


class Documented(unittest.TestCase):
    def test_every_public_name_has_a_docstring_of_its_own(self):
        aliases = documented_aliases()
        for name in names_of_package():
            value = getattr(cwm, name)
            with self.subTest(name):
                if inspect.isclass(value):
                    self.assertTrue(has_own_docstring(value))
                elif inspect.isfunction(value):
                    self.assertTrue(value.__doc__)
                else:
                    self.assertIn(name, aliases)

    def test_every_public_method_has_a_docstring(self):
        classes = [getattr(cwm, name) for name in names_of_package()]
        for cls in filter(inspect.isclass, classes):
            for base in cls.__mro__:
                if not base.__module__.startswith("cwm"):
                    continue
                for name, function in public_functions(base):
                    self.assertTrue(function.__doc__, f"{base.__name__}.{name}")

    def test_words_of_arguments_are_typed(self):
        """Where an enum is taken its names are, by a Literal: editors complete it, and type
        checkers find a wrong one.
        """
        typed = 0
        for owner in [*filter(inspect.isclass, map(vars(cwm).get, names_of_package())), cwm]:
            functions = [*public_functions(owner)] if inspect.isclass(owner) else []
            if dataclasses.is_dataclass(owner) or owner is cwm.QueryOptions:
                functions.append(("fields", owner))
            for name, function in functions:
                hints = typing.get_type_hints(function, localns=vars(cwm))
                hints.pop("return", None)
                for argument, annotation in hints.items():
                    kinds, words, is_any_text = choices(annotation)
                    if not kinds or (not words and not is_any_text):
                        continue  # an answer, which is the enum itself
                    where = f"{owner.__name__}.{name}: {argument}"
                    self.assertFalse(is_any_text, where)
                    names = {member.name.lower() for kind in kinds for member in kind}
                    self.assertTrue(words and words <= names, f"{where} takes {words}")
                    typed += 1
        self.assertGreaterEqual(typed, 12)

    def test_each_like_has_every_word_of_its_enum(self):
        likes = [name for name in vars(enums) if name.endswith("Like") and name != "PutKindLike"]
        self.assertGreaterEqual(len(likes), 10)
        for name in likes:
            kinds, words, _ = choices(getattr(enums, name))
            (kind,) = kinds
            self.assertEqual(words, {member.name.lower() for member in kind}, name)


class Cells(html.parser.HTMLParser):
    """The texts of a table's cells; anything else but a table is an error."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []

    def handle_starttag(self, tag, attrs):
        if tag not in {"table", "caption", "tr", "th", "td"}:
            raise AssertionError(f"<{tag}> does not belong into the table")

    def handle_data(self, data):
        self.texts.append(data)


class ObjectsForPeople(ServerCase):
    def test_an_object_fits_a_line_and_names_what_it_is(self):
        self.world.put("crate", cwm.Box(0.07, 0.19, 0.27), cwm.pose([0.8312, -0.2, 1.063]))
        self.assertEqual(
            repr(self.world.get("crate")),
            "Object('crate', USER, Box 70 x 190 x 270 mm, at 0.831 -0.200 1.063 m)",
        )
        several = [cwm.Placed(cwm.Cone(0.02, 0.04, 0.1), cwm.pose([k, 0, 0])) for k in (0, 1)]
        self.world.put("n" * 128, several)
        line = repr(self.world.get("n" * 128))
        self.assertLessEqual(len(line), 120)
        self.assertIn("Cone r 20 to 40, l 100 mm and 1 more", line)

    def test_a_notebook_shows_it_as_a_table_with_named_coefficients(self):
        self.world.put("can", cwm.Cylinder(0.033, 0.12), cwm.pose([0, 0, 1]))
        cells = Cells()
        cells.feed(dataclasses.replace(self.world.get("can"), name="<b>can</b>")._repr_html_())
        self.assertIn("<b>can</b> (user), at 0.000 0.000 1.000 m", cells.texts)
        self.assertIn("Cylinder r 33, l 120 mm", cells.texts)
        (coefficients,) = [text for text in cells.texts if text.startswith("point_on_axis_x")]
        self.assertIn("axis_direction_z 1.0000, radius 0.0330", coefficients)


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
        exec(code.replace('world="kitchen"', f"{address!r}, {world!r}"), here)
        self.assertEqual(here["answer"].distance_m.shape[0], 3)
        self.assertTrue(np.isfinite(here["answer"].distance_m).all())


class Names(ServerCase):
    def test_for_checkers_of_types_are_all_there_are(self):
        self.assertEqual(sorted(names_for_checkers()), sorted(names_of_package()))

    def test_taken_by_a_star_hide_none_of_the_users_own(self):
        taken: dict = {}
        exec("from cwm import *", taken)
        self.assertEqual(set(taken) - {"__builtins__"}, {"World", "connect", "pose"})
