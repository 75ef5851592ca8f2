#!/usr/bin/env python3
"""Writes the small files of corpus/ that are made by rule; files beside them were found by the fuzzer.

tests/fuzz/make_corpus.py    from anywhere
"""
import json
import pathlib
import struct

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"

VERTICES = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def write(target, name, content):
    path = CORPUS / target / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)


def glb(document, binary):
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def tetrahedron_glb(indices, mode=4, nodes=None, component=5123, **primitive):
    points = b"".join(struct.pack("<3f", *v) for v in VERTICES)
    size = {5121: "B", 5123: "H", 5125: "I"}[component]
    binary = points + struct.pack(f"<{len(indices)}{size}", *indices)
    return glb({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": nodes or [{"mesh": 0}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0}, "indices": 1, "mode": mode, **primitive}]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)},
                        {"buffer": 0, "byteOffset": len(points),
                         "byteLength": len(binary) - len(points)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(VERTICES), "type": "VEC3"},
                      {"bufferView": 1, "componentType": component, "count": len(indices),
                       "type": "SCALAR"}]}, binary)


def glbs():
    flat = [corner for triangle in TRIANGLES for corner in triangle]
    write("glb", "triangles.glb", tetrahedron_glb(flat))
    write("glb", "bytes.glb", tetrahedron_glb(flat, component=5121))
    write("glb", "words.glb", tetrahedron_glb(flat, component=5125))
    write("glb", "strip.glb", tetrahedron_glb([0, 1, 2, 3, 0, 1], mode=5))
    write("glb", "fan.glb", tetrahedron_glb([0, 1, 2, 3], mode=6))
    write("glb", "fan_of_two.glb", tetrahedron_glb([0, 1], mode=6))
    write("glb", "strip_of_one.glb", tetrahedron_glb([0], mode=5))
    write("glb", "four_corners.glb", tetrahedron_glb([0, 1, 2, 3]))
    write("glb", "targets.glb", tetrahedron_glb(flat, targets=[{"POSITION": 0}]))
    write("glb", "nodes.glb", tetrahedron_glb(flat, nodes=[
        {"children": [1, 2]},
        {"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, -1, 2]},
        {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]}]))
    doubling = [{"children": [i + 1, i + 1]} for i in range(16)] + [{"mesh": 0}]
    write("glb", "doubling.glb", tetrahedron_glb(flat, nodes=doubling))


def stl_and_obj():
    binary = b"x" * 80 + struct.pack("<I", len(TRIANGLES))
    text = "solid part\n"
    for triangle in TRIANGLES:
        corners = [VERTICES[v] for v in triangle]
        binary += struct.pack("<12fH", 0, 0, 0, *corners[0], *corners[1], *corners[2], 0)
        text += "facet normal 0 0 0\nouter loop\n"
        text += "".join("vertex %g %g %g\n" % corner for corner in corners) + "endloop\nendfacet\n"
    write("stl", "binary.stl", binary)
    write("stl", "text.stl", text + "endsolid part\n")
    points = "".join("v %g %g %g\n" % v for v in VERTICES)
    write("obj", "triangles.obj", points + "".join("f %d %d %d\n" % tuple(v + 1 for v in t)
                                                   for t in TRIANGLES))
    write("obj", "corners.obj", points + "o a\ng b\nf 1/1 2//2 -2/1/1 -1 # four\nl 1 2\nf 1 2 \\\n3\n")
    star = "".join("v %d %d 0\n" % (x, x * x % 17) for x in range(40))
    write("obj", "polygon.obj", star + "f " + " ".join(str(i + 1) for i in range(40)) + "\n")


def collada(scene, library="", primitives=None):
    positions = " ".join("%g %g %g" % v for v in VERTICES)
    primitives = primitives or ("<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>"
                                + " ".join(str(v) for t in TRIANGLES for v in t) + "</p></triangles>")
    return (f'<COLLADA version="1.4.1"><asset><unit meter="0.5"/><up_axis>Z_UP</up_axis></asset>'
            f'<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">{positions}'
            f'</float_array><technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>'
            f'<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{primitives}</mesh></geometry>'
            f'</library_geometries><library_nodes>{library}</library_nodes><library_visual_scenes>'
            f'<visual_scene id="s">{scene}</visual_scene></library_visual_scenes><scene>'
            f'<instance_visual_scene url="#s"/></scene></COLLADA>')


def colladas():
    use = '<instance_geometry url="#g"/>'
    write("collada", "plain.dae", collada(f"<node>{use}</node>"))
    write("collada", "transforms.dae", collada(
        f'<node><translate>1 2 3</translate><rotate>0 0 1 90</rotate><scale>1 -1 2</scale>{use}<node><matrix>1 0 0 5 '
        f'0 1 0 0 0 0 1 0 0 0 0 1</matrix>{use}</node></node>'))
    vertex = '<input semantic="VERTEX" source="#v" offset="0"/>'
    write("collada", "polylist.dae", collada(
        f"<node>{use}</node>", primitives=f'<polylist count="2">{vertex}<vcount>4 3</vcount><p>0 1 2 3 0 1 3</p>'
        f'</polylist><polygons>{vertex}<p>0 1 2</p><p>0 1 2 3</p></polygons>'))
    # Without the rule for corners, every list would repeat all counts.
    write("collada", "empty_lists.dae", collada(
        f"<node>{use}</node>", primitives=f'<polylist>{vertex}<vcount>{"0 " * 400}</vcount>{"<p/>" * 400}</polylist>'))
    doubling = "".join(f'<node id="n{i}"><instance_node url="#n{i + 1}"/><instance_node url="#n{i + 1}"/></node>'
                       for i in range(15))
    write("collada", "doubling.dae", collada(
        '<node><instance_node url="#n0"/></node>', library=doubling + f'<node id="n15">{use}</node>'))


def robots():
    joint = ('<joint name="j{0}" type="{1}"><origin xyz="0 0 1" rpy="0 1 0"/><parent link="{2}"/><child link="{3}"/>'
             '<axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="2" effort="3"/>{4}</joint>')
    shape = '<collision name="c"><origin xyz="1 0 0"/><geometry>{0}</geometry></collision>'
    write("urdf", "arm.urdf", '<robot name="r"><link name="a">' + shape.format('<box size="1 2 3"/>')
          + shape.format('<cylinder radius="1" length="2"/>') + '</link><link name="b">'
          + shape.format('<sphere radius="1"/>') + shape.format('<capsule radius="1" length="2"/>')
          + '</link><link name="c">' + shape.format('<mesh filename="m.obj" scale="1 -2 3"/>')
          + shape.format('<mesh filename="m.obj"/>') + '</link><link name="d"/>'
          + joint.format(1, "revolute", "a", "b", "") + joint.format(2, "prismatic", "b", "c", '<mimic joint="j1"/>')
          + joint.format(3, "floating", "a", "d", "") + "</robot>")
    write("urdf", "links.urdf", '<robot name="r">' + "".join(f'<link name="l{i}"/>' for i in range(40)) + "".join(
        joint.format(i, "planar" if i % 2 else "continuous", f"l{i - 1}", f"l{i}", "") for i in range(1, 40))
        + "</robot>")
    write("srdf", "arm.srdf", '<robot name="arm"><group name="reach"><joint name="elbow"/><joint name="slide"/></group>'
          '<group name="chain"><chain base_link="base" tip_link="left"/><link name="free"/><group name="reach"/></group>'
          '<group_state name="ready" group="reach"><joint name="elbow" value="0.5"/></group_state>'
          '<disable_collisions link1="base" link2="upper" reason="Adjacent"/><enable_collisions link1="base" '
          'link2="upper"/><disable_default_collisions link="upper"/><passive_joint name="gone"/>'
          '<virtual_joint name="v" type="floating" parent_frame="world" child_link="base"/>'
          '<end_effector name="e" group="reach" parent_link="fore"/></robot>')


def mesh_bytes():
    counts = struct.pack("<II", len(VERTICES), len(TRIANGLES))
    body = b"".join(struct.pack("<3d", *v) for v in VERTICES) + b"".join(struct.pack("<3I", *t) for t in TRIANGLES)
    write("mesh_bytes", "tetrahedron", counts + body)
    write("mesh_bytes", "empty", struct.pack("<II", 0, 0))
    write("mesh_bytes", "too_many", struct.pack("<II", 0xFFFFFFFF, 0xFFFFFFFF) + body)


def clouds():
    header = ("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\n"
              "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ")
    rows = "".join("%g %g %g\n" % v for v in VERTICES)
    floats = b"".join(struct.pack("<3f", *v) for v in VERTICES)
    write("cloud", "text.pcd", header + "ascii\n" + rows)
    write("cloud", "binary.pcd", header.encode() + b"binary\n" + floats)
    literals = b"".join(bytes([len(part) - 1]) + part for part in (floats[:32], floats[32:]))  # LZF without matches
    write("cloud", "compressed.pcd", header.encode() + b"binary_compressed\n"
          + struct.pack("<II", len(literals), len(floats)) + literals)
    ply = ("ply\nformat {0} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 4\nproperty list uchar int vertex_indices\nend_header\n")
    write("cloud", "text.ply", ply.format("ascii") + rows + "".join("3 %d %d %d\n" % t for t in TRIANGLES))
    for order, sign in (("little", "<"), ("big", ">")):
        body = b"".join(struct.pack(sign + "3f", *v) for v in VERTICES)
        body += b"".join(struct.pack(sign + "B3i", 3, *t) for t in TRIANGLES)
        write("cloud", f"{order}.ply", ply.format(f"binary_{order}_endian").encode() + body)
    write("cloud", "plain.xyz", "# x y z\n" + rows)
    write("cloud", "columns.xyz", "x,y,z,label\n" + rows.replace(" ", ",").replace("\n", ",1\n"))
    text = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3), }"
    text += " " * (-(len(text) + 11) % 64) + "\n"
    write("cloud", "array.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + floats)


def scenes():
    write("scene", "world.scene", "shelf\n* box\n1\nbox\n1 2 3\n0 0 1\n0 0 0 1\n0 0 0 0\n* part\n1\nmesh\n3 1\n0 0 0\n"
          "1 0 0\n0 1 0\n0 1 2\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n")
    write("scene", "world.yaml", "name: shelf\nrobot_model_name: arm\nworld:\n  collision_objects:\n    - id: box\n"
          "      header: {frame_id: world}\n      operation: add\n      primitives:\n        - type: box\n"
          "          dimensions: [1, 2, 3]\n        - {type: cylinder, dimensions: [1, 0.5]}\n"
          "      primitive_poses:\n        - {position: [0, 0, 1], orientation: [0, 0, 0, 1]}\n"
          "        - {position: [0, 0, 1], orientation: [0, 0, 0, 1]}\n    - id: part\n      meshes:\n"
          "        - vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n          triangles: [[0, 1, 2]]\n"
          "      mesh_poses:\n        - {position: [0, 0, 1], orientation: [0, 0, 0, 1]}\n"
          "robot_state:\n  joint_state: {name: [elbow], position: [0.5]}\n"
          "allowed_collision_matrix:\n  entry_names: [a, b]\n  entry_values: [[0, 1], [1, 0]]\n")
    write("scene", "request.yaml", "group_name: reach\nallowed_planning_time: 5\nstart_state:\n  joint_state:\n"
          "    name: [elbow]\n    position: [0]\ngoal_constraints:\n  - joint_constraints:\n"
          "      - {joint_name: elbow, position: 1, tolerance_above: 0.1, tolerance_below: 0.1}\n")
    write("scene", "aliases.yaml", "name: x\na: &a [1, 1, 1, 1]\nb: &b [*a, *a, *a, *a]\nc: &c [*b, *b, *b, *b]\n"
          "world:\n  collision_objects: *c\n")


def varint(number):
    encoded = b""
    number &= (1 << 64) - 1
    while number >= 0x80:
        encoded += bytes([number & 0x7F | 0x80])
        number >>= 7
    return encoded + bytes([number])


def message(*fields):
    """A protobuf message of pairs (field number, value): int, float, text, bytes, or a list of doubles."""
    encoded = b""
    for number, value in fields:
        if isinstance(value, int):
            encoded += varint(number << 3) + varint(value)
        elif isinstance(value, float):
            encoded += varint(number << 3 | 1) + struct.pack("<d", value)
        else:
            if isinstance(value, list):
                value = struct.pack(f"<{len(value)}d", *value)
            value = value.encode() if isinstance(value, str) else value
            encoded += varint(number << 3 | 2) + varint(len(value)) + value
    return encoded


def records():
    """Of proto/cwm/store/v1/record.proto: what follows a record that puts the object "a"."""
    pose = message((1, [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0]))
    revisions = [(7, 1), (8, 1), (9, 2), (10, 4), (11, 1)]
    mesh = struct.pack("<II", 4, 4) + b"".join(struct.pack("<3d", *v) for v in VERTICES)
    mesh += b"".join(struct.pack("<3I", *t) for t in TRIANGLES)
    shapes = {
        "sphere": (1, 0.1), "box": (2, message((1, [1.0, 2.0, 3.0]))), "cone": (4, message((1, [0.1, 0.0, 0.3]))),
        "half_space": (6, b""), "convex": (8, message((1, mesh))),
        "plate": (7, message((1, message((1, [-1.0, -1, 1, -1, 1, 1, -1, 1]))), (3, 0.1))),
        "mesh": (9, message((1, mesh), (3, 1), (4, message((1, [0.0] * 6), (2, 0.1), (3, 0.2))), (5, 1)))}
    fit = message((1, 0.1), (3, 7), (6, [0.1, 0.2, 0.3]))
    box = message((1, pose), (2, [0.1, 0.2, 0.3]))
    parts = [(1, message((1, pose), (2, message(shape)), (4, fit), (6, box))) for shape in shapes.values()]
    handle = (3, message((1, 0), (2, 3), (3, [0, 0, 1.0]), (4, box), (5, message((1, mesh)))))
    model = message(*parts, (2, message((1, message((1, mesh))), (2, 9))), handle, (4, 11))
    rule = message((1, message((1, "a"))), (2, message((1, "b"), (2, "l"))), (3, 1), (4, 1 << 60), (5, 0.1))

    def record(*write):
        return message((1, "uid"), (2, 2), (3, 1 << 60), (6, message((1, 1), *write)))

    def change(name, *after):
        return (2, message((1, name), (2, message((1, name), (4, pose), *revisions, *after))))

    write("record", "move.bin", record(change("a")))
    write("record", "shapes.bin", record(change("b", (2, model), (3, 0.1), (6, "a"))))
    write("record", "removal.bin", record((2, message((1, "a")))))
    write("record", "rule.bin", record((4, rule)))
    write("record", "robot.bin", record((3, message((1, "r"), (2, message((1, "r"), (2, message((1, "00"))),
                                                                         (3, pose), (4, [0.5])))))))
    write("record", "facts.bin", record((5, message((1, "a"), (2, 1), (3, 1))), (6, 1 << 60),
                                        (7, message((1, "s"), (2, pose))), (8, message((1, "id"), (2, "digest"))),
                                        (9, message((1, "object"), (2, 7)))))
    write("record", "deletion.bin", message((1, "uid"), (2, 1), (7, message((1, "uid"), (2, "id")))))
    write("record", "skip.bin", message((1, "uid"), (2, 65537), (6, message((1, 1)))))
    object_a = message((1, "a"), (2, model), (4, pose), *revisions)
    write("record", "snapshot.bin", message((1, "uid"), (2, "w"), (3, 9), (4, object_a), (6, rule),
                                            (7, message((1, "s"), (2, pose))),
                                            (8, message((1, message((1, "id"))), (2, 9), (3, 1 << 60))),
                                            (9, message((1, "object"), (2, 7))), (10, message((1, "a"), (2, 5)))))


if __name__ == "__main__":
    glbs()
    stl_and_obj()
    colladas()
    robots()
    mesh_bytes()
    clouds()
    scenes()
    records()
