"""Writes whose reply is lost on the way: done once, and answered as if nothing had been."""

import threading
import time

import numpy as np

import cwm
from cwm.v1 import world_pb2
from lossy_line import LossyLine
from server_case import ServerCase

PATIENCE_S = 20.0
ARM = """<robot name="arm"><link name="base"/><link name="tip"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


def table_scan() -> np.ndarray:
    """A plane of 0.8 x 0.6 m, 1 m before the sensor, as an organised cloud."""
    x, y = np.meshgrid(np.linspace(-0.4, 0.4, 160), np.linspace(-0.3, 0.3, 120))
    return np.stack([x, y, np.ones_like(x)], -1)


class LostReplies(ServerCase):
    def setUp(self) -> None:
        super().setUp()
        self.line = LossyLine(self.running.address)
        self.addCleanup(self.line.close)
        self.writer = cwm.connect(self.line.address, self.world.name)
        self.addCleanup(self.writer.close)
        self.world.put("cup", cwm.Sphere(0.05))

    def lose_reply_to(self, write, meanwhile):
        """What `write` returns in the end, where its first reply never arrived and the world went
        on with `meanwhile` before it was sent again.
        """
        before = self.world.revision
        answers: list = []

        def work() -> None:
            try:
                answers.append(write())
            except cwm.Error as error:
                answers.append(error)

        self.line.lose_replies()
        writing = threading.Thread(target=work)
        writing.start()
        end = time.monotonic() + PATIENCE_S
        while self.world.revision == before:  # until the server has done it
            self.assertLess(time.monotonic(), end, "the write never reached the server")
            time.sleep(0.005)
        self.assertEqual(self.world.revision, before + 1)
        meanwhile()
        self.assertEqual(answers, [], "a reply arrived, so nothing was lost")
        self.line.cut()
        writing.join(PATIENCE_S)
        self.assertEqual(len(answers), 1, "the write was not sent again")
        self.assertNotIsInstance(answers[0], cwm.Error)
        self.assertEqual(self.world.revision, before + 2, "it was done once more")
        return answers[0]

    def move_away(self) -> None:
        self.world.move("cup", cwm.pose([5, 0, 0]))

    def test_of_a_move_do_not_move_back_what_another_moved(self):
        revision = self.lose_reply_to(
            lambda: self.writer.move("cup", cwm.pose([1, 0, 0])), self.move_away
        )
        self.assertEqual(revision, 2)
        self.assertEqual(self.world.get("cup").position.tolist(), [5, 0, 0])

    def test_of_a_move_that_expected_a_revision_raise_no_conflict(self):
        revision = self.lose_reply_to(
            lambda: self.writer.move("cup", cwm.pose([1, 0, 0]), expected_revision=1),
            self.move_away,
        )
        self.assertEqual(revision, 2)

    def test_of_a_removal_do_not_remove_the_successor(self):
        revision = self.lose_reply_to(
            lambda: self.writer.remove("cup"), lambda: self.world.put("cup", cwm.Sphere(0.2))
        )
        self.assertEqual(revision, 2)
        self.assertEqual(self.world.get("cup").parts[0].shape, cwm.Sphere(0.2))

    def test_of_a_scan_tell_what_the_first_made_of_it(self):
        result = self.lose_reply_to(lambda: self.writer.ingest(table_scan()), self.move_away)
        self.assertEqual(result.revision, 2)
        self.assertEqual([obj.name for obj in result.supports], ["support_1"])
        supports = self.world.objects(kind="support")
        self.assertEqual([obj.name for obj in supports], ["support_1"])

    def test_of_robots_load_one_and_delete_none_that_came_later(self):
        robot = self.lose_reply_to(lambda: self.writer.load_robot(ARM), self.move_away)
        self.assertEqual(robot.name, "arm")
        revision = self.lose_reply_to(
            lambda: self.writer.delete_robot("arm"), lambda: self.world.load_robot(ARM)
        )
        self.assertEqual(revision, 4)
        self.assertEqual([one.name for one in self.world.robots()], ["arm"])


class RequestIds(ServerCase):
    def put(self, name: str, x_m: float, **fields) -> world_pb2.ApplyChangesRequest:
        request = world_pb2.ApplyChangesRequest(world=self.world.name, **fields)
        obj = request.changes.add().put.object
        obj.name, obj.x_world_object.tx_m, obj.x_world_object.qw = name, x_m, 1
        obj.shapes.add(x_object_shape={"qw": 1}, sphere={"radius_m": 0.1})
        return request

    def apply(self, request: world_pb2.ApplyChangesRequest) -> world_pb2.ApplyChangesResponse:
        connection = self.world.connection
        return connection.call(connection.worlds.ApplyChanges, request, PATIENCE_S)

    def test_that_name_another_write_are_refused_and_change_nothing(self):
        first = self.apply(self.put("a", 0, request_id="one"))
        others = {
            "another place": self.put("a", 1, request_id="one"),
            "another name": self.put("b", 0, request_id="one"),
            "another expectation": self.put("a", 0, request_id="one", expected_revision=7),
        }
        more = self.put("a", 0, request_id="one")
        more.changes.add().remove.name = "a"
        others["one change more"] = more
        for what, request in others.items():
            with self.subTest(what), self.assertRaises(cwm.FailedPrecondition) as caught:
                self.apply(request)
            self.assertEqual(caught.exception.reason, "REQUEST_ID_REUSED")
        self.assertEqual((self.world.revision, len(self.world.objects())), (1, 1))
        self.world.remove("a")
        self.assertEqual(self.apply(self.put("a", 0, request_id="one")), first)
        self.assertEqual((self.world.revision, len(self.world.objects())), (2, 0))

    def test_count_in_their_own_world(self):
        self.apply(self.put("a", 0, request_id="one"))
        elsewhere = self.put("b", 1, request_id="one")
        elsewhere.world = self.world.name + "_2"
        self.assertEqual(self.apply(elsewhere).revision, 1)
