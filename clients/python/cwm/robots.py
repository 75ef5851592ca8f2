"""Robots of a world as values, and the files that make one."""

from __future__ import annotations

import os
import pathlib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from typing import Mapping, Sequence, Union

import numpy as np
import numpy.typing as npt

from cwm import arrays, enums, poses
from cwm.v1 import robot_model_pb2

PathOrText = Union[str, os.PathLike]

# A URDF is usually in PACKAGE/urdf: packages are searched in its folder and this many folders
# above.
_FOLDERS_ABOVE = 3
# Workspaces nest repositories and stacks of packages, not much more.
_MAX_DEPTH = 5
_PACKAGE, _FILE = "package://", "file://"


@dataclass(frozen=True)
class Link:
    """A link and the joint that it hangs on; the root has none."""

    name: str
    parent: str
    joint: str
    joint_kind: enums.JointKind
    follows: str
    collision_count: int
    triangle_count: int
    sphere_count: int
    padding_m: float = 0.0  # extra margin against the world, not against the robot itself
    scale: float = 1.0  # of its collision geometry, about its own origin


@dataclass(frozen=True)
class Variable:
    """One number of a state: rad or m."""

    name: str
    joint: str
    joint_kind: enums.JointKind
    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class Group:
    """Joints of the SRDF: a row of a query has one number for each of their variables, in
    this order.
    """

    name: str
    joints: tuple[str, ...]
    states: Mapping[str, Mapping[str, float]]  # by name; rad or m by variable


@dataclass(frozen=True, eq=False)  # poses are arrays
class Tool:
    """A frame in which a tool acts: `pose` is X_link_tool, (4, 4) or (7,), None: the link's frame.
    group: that which moves it and uses it by default.
    """

    name: str
    link: str
    pose: npt.ArrayLike | None = None
    group: str = ""


@dataclass(frozen=True)
class Robot:
    """A robot of a world. `pose` is X_WB, its root link in the world."""

    name: str
    uid: str
    links: tuple[Link, ...] = field(repr=False)
    variables: tuple[Variable, ...] = field(repr=False)
    groups: Mapping[str, Group] = field(repr=False, hash=False)
    self_pair_count: int
    pose: np.ndarray = field(compare=False, repr=False)
    state: Mapping[str, float] = field(
        hash=False
    )  # rad or m by variable, in the order of `variables`
    create_revision: int
    state_revision: int
    tools: tuple[Tool, ...] = field(default=(), repr=False, compare=False)

    def variables_of(self, group: str = "") -> tuple[Variable, ...]:
        """What a row of the group has, in its order; of the whole robot without one. KeyError
        for an unknown group.
        """
        if not group:
            return self.variables
        by_joint: dict[str, list[Variable]] = {}
        for variable in self.variables:
            by_joint.setdefault(variable.joint, []).append(variable)
        return tuple(
            variable for joint in self.groups[group].joints for variable in by_joint[joint]
        )

    def limits(self, group: str = "") -> np.ndarray:
        """(dof, 2): lower and upper of each number of a row; -inf and inf where there is none."""
        return np.array(
            [
                (-np.inf if v.lower is None else v.lower, np.inf if v.upper is None else v.upper)
                for v in self.variables_of(group)
            ]
        ).reshape(-1, 2)

    def row(self, group: str = "", named_state: str = "") -> np.ndarray:
        """(dof,): where the robot is, or where a named state of the group puts it. ValueError where
        that says nothing that its joints can take.
        """
        named = self.groups[group].states[named_state] if named_state else {}
        if named_state and not named:
            raise ValueError(f"{named_state!r} says nothing that joints of {group!r} can take")
        values = {**self.state, **named}
        return np.array([values[variable.name] for variable in self.variables_of(group)])


def robot_from_proto(message: robot_model_pb2.Robot) -> Robot:
    variables = tuple(
        Variable(
            v.name,
            v.joint,
            enums.JointKind(v.joint_kind),
            v.lower if v.HasField("lower") else None,
            v.upper if v.HasField("upper") else None,
        )
        for v in message.variables
    )
    groups = {
        group.name: Group(
            group.name,
            tuple(group.joints),
            {
                state.name: {value.variable: value.value for value in state.values}
                for state in group.states
            },
        )
        for group in message.groups
    }
    links = tuple(
        Link(
            link.name,
            link.parent,
            link.joint,
            enums.JointKind(link.joint_kind),
            link.follows,
            link.collision_count,
            link.triangle_count,
            link.sphere_count,
            link.padding_m,
            link.scale,
        )
        for link in message.links
    )
    return Robot(
        message.name,
        message.uid,
        links,
        variables,
        groups,
        message.self_pair_count,
        poses.from_proto(message.x_world_base),
        dict(zip((v.name for v in variables), message.state)),
        message.create_revision,
        message.state_revision,
        tuple(
            Tool(tool.name, tool.link, poses.from_proto(tool.x_link_tool), tool.group)
            for tool in message.tools
        ),
    )


def paddings_to_proto(
    paddings: Mapping[str, float] | None, name: str
) -> list[robot_model_pb2.LinkPadding]:
    return [
        robot_model_pb2.LinkPadding(link=link, padding_m=value)
        for link, value in _of_links(paddings, name)
    ]


def scales_to_proto(
    scales: Mapping[str, float] | None, name: str
) -> list[robot_model_pb2.LinkScale]:
    return [
        robot_model_pb2.LinkScale(link=link, scale=value) for link, value in _of_links(scales, name)
    ]


def _of_links(values: Mapping[str, float] | None, name: str) -> list[tuple[str, float]]:
    if values is not None and not isinstance(values, Mapping):
        raise TypeError(f"{name} is {values!r}, must be a mapping of link names to numbers")
    return [
        (arrays.text(link, name), arrays.number(value, f"{name}[{link!r}]", low=0))
        for link, value in (values or {}).items()
    ]


def tools_to_proto(tools: Sequence[Tool], name: str) -> list[robot_model_pb2.RobotTool]:
    messages = []
    for i, tool in enumerate(tools):
        if not isinstance(tool, Tool):
            raise TypeError(f"{name}[{i}] is {tool!r}, must be a cwm.Tool")
        message = robot_model_pb2.RobotTool(
            name=arrays.text(tool.name, f"{name}[{i}].name"),
            link=arrays.text(tool.link, f"{name}[{i}].link"),
            group=arrays.text(tool.group, f"{name}[{i}].group"),
        )
        if tool.pose is not None:
            message.x_link_tool.CopyFrom(poses.to_proto(tool.pose, f"{name}[{i}].pose"))
        messages.append(message)
    return messages


def joint_state(
    values: Mapping[str, float] | None, named_state: tuple[str, str] | None, name: str
) -> robot_model_pb2.RobotJointState:
    """A state that the SRDF names, as (group, state), and values by variable on top of it."""
    message = robot_model_pb2.RobotJointState()
    if named_state is not None:
        if isinstance(named_state, str) or len(named_state) != 2:
            raise TypeError(f"named_state is {named_state!r}, must be (group, state)")
        message.group = arrays.text(named_state[0], "named_state[0]")
        message.named_state = arrays.text(named_state[1], "named_state[1]")
    if values is not None and not isinstance(values, Mapping):
        raise TypeError(f"{name} is {values!r}, must be a mapping of joint names to rad or m")
    for variable, value in (values or {}).items():
        message.values.add(
            variable=arrays.text(variable, name),
            value=arrays.number(value, f"{name}[{variable!r}]"),
        )
    return message


def read_text(source: PathOrText, name: str) -> tuple[bytes, pathlib.Path]:
    """The text of an XML file and the folder that it lies in; what begins with "<" is the text
    itself.
    """
    if isinstance(source, str) and source.lstrip().startswith("<"):
        return source.encode(), pathlib.Path.cwd()
    if not isinstance(source, (str, os.PathLike)):
        raise TypeError(f"{name} is {source!r}, must be a path or the text of the file")
    path = pathlib.Path(source)
    return path.read_bytes(), path.parent


def collision_mesh_uris(urdf: bytes) -> list[str]:
    """As the URDF has them, each once. None of what is no XML: the server says what is wrong
    with it.
    """
    try:
        root = ElementTree.fromstring(urdf)
    except ElementTree.ParseError:
        return []
    uris = (mesh.get("filename", "") for mesh in root.iterfind("link/collision/geometry/mesh"))
    return [uri for uri in dict.fromkeys(uris) if uri]


def _is_package(folder: pathlib.Path, package: str) -> bool:
    """By its name, or by the one that its package.xml has: checkouts are called anything."""
    if folder.resolve().name == package:
        return True
    try:
        root = ElementTree.parse(folder / "package.xml").getroot()
    except (OSError, ElementTree.ParseError):
        return False
    return root.findtext("name") == package


def _package_below(
    folder: pathlib.Path, package: str, depth: int = 0
) -> pathlib.Path | None:
    """The first folder below, by path, whose package.xml has the name; like catkin and colcon,
    the search does not enter packages.
    """
    try:
        below = sorted(p for p in folder.iterdir() if p.is_dir() and not p.name.startswith("."))
    except OSError:
        return None
    for path in below:
        has_package = (path / "package.xml").exists()
        if has_package and _is_package(path, package):
            return path
        if has_package or depth >= _MAX_DEPTH:
            continue
        found = _package_below(path, package, depth + 1)
        if found is not None:
            return found
    return None


def find_mesh(uri: str, folder: pathlib.Path, package_dirs: Sequence[PathOrText]) -> pathlib.Path:
    """The file of a mesh URI; FileNotFoundError says where it was looked for."""
    if uri.startswith(_FILE):
        candidates = [pathlib.Path(uri[len(_FILE) :])]
    elif uri.startswith(_PACKAGE):
        above = folder.resolve()
        roots = [pathlib.Path(d) for d in package_dirs] or [
            above,
            *list(above.parents)[:_FOLDERS_ABOVE],
        ]
        package, _, rest = uri[len(_PACKAGE) :].lstrip("/").partition("/")
        candidates = []
        for root in roots:
            candidates.append(root / package / rest)
            if rest and _is_package(root, package):
                candidates.append(root / rest)
        for root in map(pathlib.Path, package_dirs if rest else ()):
            found = _package_below(root, package)
            if found is not None:
                candidates.append(found / rest)
    elif "://" in uri:
        raise FileNotFoundError(
            f"mesh {uri} of the URDF must be at {_PACKAGE}, at {_FILE} or a path"
        )
    else:
        candidates = [folder / uri]
    for path in candidates:
        if path.is_file():
            return path
    looked = ", ".join(str(path) for path in candidates)
    raise FileNotFoundError(f"mesh {uri} of the URDF was not found, looked for {looked}")
