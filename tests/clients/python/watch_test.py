"""Watches: order, and what they survive."""

import threading
import time
import unittest

import cwm
from server_case import ServerCase


class Watches(ServerCase):
    def setUp(self) -> None:
        super().setUp()
        self.world.put("ball", cwm.Sphere(0.1))

    def events_until(self, events: cwm.Watch, revision: int) -> list:
        told = []
        while not told or told[-1].revision < revision:
            event = next(events)
            if not isinstance(event, cwm.Bookmark):
                told.append(event)
        return told

    def test_tell_the_world_and_then_every_change_in_order(self):
        robot = '<robot name="r"><link name="a"/></robot>'
        with self.world.watch() as events:
            first = next(events)
            self.assertEqual((type(first), first.revision, first.anew), (cwm.Snapshot, 1, ""))
            self.assertEqual([obj.name for obj in first.objects], ["ball"])
            self.world.move("ball", cwm.pose([1, 0, 0]))
            self.world.apply([cwm.Put("cube", cwm.Box(1, 1, 1)), cwm.Allow("cube", "ball")])
            self.world.load_robot(robot)
            self.world.set_robot_state("r", pose=cwm.pose([0, 0, 1]))
            self.world.remove("ball")
            self.world.delete_robot("r")
            told = self.events_until(events, 7)
        self.assertEqual([event.revision for event in told], list(range(2, 8)))
        self.assertEqual(
            [[type(e) for e in event.events] for event in told],
            [
                [cwm.ObjectMoved],
                [cwm.ObjectPut, cwm.RuleSet],
                [cwm.RobotPut],
                [cwm.RobotMoved],
                [cwm.ObjectRemoved],
                [cwm.RobotRemoved],
            ],
        )
        self.assertEqual(told[0].events[0].pose[0, 3], 1)
        self.assertEqual(told[1].events[0].object.name, "cube")
        self.assertTrue(told[1].events[1].rule.allowed)
        self.assertEqual(list(events), [])  # it has ended

    def test_go_on_from_a_revision(self):
        for i in range(5):
            self.world.move("ball", cwm.pose([i + 1, 0, 0]))
        uid = self.world.uid
        with self.world.watch(from_revision=3, world_uid=uid) as events:
            self.assertEqual([event.revision for event in self.events_until(events, 6)], [4, 5, 6])
        future = self.world.watch(from_revision=99, world_uid=uid)
        with future as events, self.assertRaises(cwm.OutOfRange):
            next(events)
        with self.world.watch(from_revision=0) as events:
            self.assertEqual(next(events).revision, 1)
        with self.assertRaisesRegex(ValueError, "world_uid is absent.* revision 3 is"):
            self.world.watch(from_revision=3)
        with self.world.watch(from_revision=3, world_uid="another") as events:
            first = next(events)
            self.assertEqual((type(first), first.revision), (cwm.Snapshot, 6))
            self.assertIn("replaced", first.anew)
        with self.assertRaisesRegex(ValueError, "from_revision is -1, must be at least 0"):
            self.world.watch(from_revision=-1)

    def test_coalesced_lose_no_removal(self):
        with self.world.watch(coalesced=True) as events:
            next(events)
            for i in range(200):
                self.world.move("ball", cwm.pose([i + 1, 0, 0]))
            last = self.world.remove("ball")
            told = self.events_until(events, last)
        self.assertIn(cwm.ObjectRemoved("ball"), told[-1].events)

    def test_survive_a_restart_and_say_that_they_began_anew(self):
        with self.world.watch() as events:
            before = next(events)
            told: list = []
            reader = threading.Thread(
                target=lambda: told.extend(self.events_until(events, 1)), daemon=True
            )
            reader.start()
            self.running.restart()
            time.sleep(0.3)  # the watch meets a server that does not know the world yet
            self.world.put("cube", cwm.Box(1, 1, 1))
            reader.join(20)
            self.assertFalse(reader.is_alive())
            self.assertEqual([obj.name for obj in told[0].objects], ["cube"])
            self.assertNotEqual(told[0].world_uid, before.world_uid)
            self.assertIn("replaced", told[0].anew)
            self.world.remove("cube")
            self.assertEqual(self.events_until(events, 2)[0].events, (cwm.ObjectRemoved("cube"),))

    def test_resume_after_a_lost_connection_without_a_gap(self):
        with self.world.watch() as events:
            next(events)
            self.world.move("ball", cwm.pose([1, 0, 0]))
            self.assertEqual(self.events_until(events, 2)[0].revision, 2)
            # The connection breaks during the watch; changes made meanwhile are reported
            # afterwards.
            events._call.cancel()
            events._lose(cwm.Unavailable("cut"))
            self.world.move("ball", cwm.pose([2, 0, 0]))
            self.world.move("ball", cwm.pose([3, 0, 0]))
            self.assertEqual([event.revision for event in self.events_until(events, 4)], [3, 4])

    def test_end_when_the_world_is_deleted_or_the_server_stays_away(self):
        with self.world.watch() as events:
            next(events)
            self.world.server.delete_world(self.world.name)
            with self.assertRaises(cwm.NotFound) as caught:
                list(events)
            self.assertEqual(caught.exception.reason, "WORLD_DELETED")
        self.world.put("ball", cwm.Sphere(0.1))
        with self.world.watch(give_up_after_s=0.5) as events:
            next(events)
            self.running.stop()
            try:
                with self.assertRaises(cwm.Unavailable):
                    list(events)
            finally:
                self.running.start()

    def test_are_closed_from_another_thread(self):
        events = self.world.watch()
        next(events)
        timer = threading.Timer(0.2, events.close)
        timer.start()
        self.assertTrue(all(isinstance(event, cwm.Bookmark) for event in events))
        timer.join()


if __name__ == "__main__":
    unittest.main()
