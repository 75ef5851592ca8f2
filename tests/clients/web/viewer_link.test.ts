// A connection that is silent, refused or busy: the messages shown, the retries, and the answers of
// its calls.
import assert from "node:assert/strict";
import { test } from "node:test";
import { CallFailure } from "../../../clients/web/src/viewer/rpc_client";
import { connectionText } from "../../../clients/web/src/viewer/panels/toolbar";
import { connectionErrorOf } from "../../../clients/web/src/viewer/connection_error";
import { CoalescedTask, LatestRequest, TransientError, withRetries } from "../../../clients/web/src/viewer/retry";
import { HeartbeatMonitor } from "../../../clients/web/src/viewer/heartbeat";

test("a connection is silent after three bookmarks that did not come", () => {
  const heartbeat = new HeartbeatMonitor();
  heartbeat.opened(1000);
  for (let now = 1000; now <= 61_000; now += 5000) {
    assert.equal(heartbeat.isTimedOut(now), false);
    heartbeat.received(now);
  }
  assert.equal(heartbeat.isTimedOut(76_000), false);
  assert.equal(heartbeat.isTimedOut(76_001), true);
});

test("a line too slow for one message is given ever longer, and a good one is judged as the first was", () => {
  const heartbeat = new HeartbeatMonitor();
  let now = 0;
  const silentFor = (ms: number): boolean => heartbeat.isTimedOut(now += ms);
  for (const [short, long] of [[14_000, 2000], [29_000, 2000], [59_000, 2000], [119_000, 2000], [119_000, 2000]] as const) {
    heartbeat.opened(now);
    now += 100;
    heartbeat.received(now);  // something small comes at once
    assert.equal(silentFor(short), false);
    assert.equal(silentFor(long), true);
  }
  heartbeat.opened(now);
  for (let i = 0; i < 30; ++i) heartbeat.received(now += 5000);
  assert.equal(silentFor(14_000), false);
  assert.equal(silentFor(2000), true);
});

test("what refuses a socket is said, and only what can pass is asked again", () => {
  assert.deepEqual(connectionErrorOf(403, "token: is absent; open the address that cwm-server printed\n", null),
                   { why: "token: is absent; open the address that cwm-server printed", isFinal: true, wait_ms: 0 });
  const full = connectionErrorOf(503, "socket: there are 64 already, must be at most as many\n", "10");
  assert.equal(full.isFinal, false);
  assert.equal(full.wait_ms, 10_000);
  assert.match(full.why, /64 already/);
  assert.equal(connectionErrorOf(503, "", null).wait_ms, 0);
  assert.equal(connectionErrorOf(503, "", "Wed, 21 Oct 2015 07:28:00 GMT").wait_ms, 0);
  assert.match(connectionErrorOf(426, "Upgrade: must be websocket", null).why, /its socket does not open/);
  assert.match(connectionErrorOf(404, "<html>", null).why, /answered with 404/);
  assert.ok(connectionErrorOf(403, "x".repeat(9999), null).why.length <= 300);
});

test("the head of the page says how the connection is and why", () => {
  assert.equal(connectionText({ is: "open" }), "Connected");
  assert.equal(connectionText({ is: "connecting", why: "" }), "Connecting \u2026");
  assert.equal(connectionText({ is: "waiting", why: "" }), "No connection, trying again \u2026");
  for (const is of ["waiting", "connecting"] as const) {
    assert.equal(connectionText({ is, why: "the server was silent" }), "No connection: the server was silent, trying again \u2026");
  }
  assert.equal(connectionText({ is: "refused", why: "token: is absent" }), "Refused: token: is absent");
});

const callFailure = (code: number): CallFailure =>
  new CallFailure({ code, name: "", message: `code ${code}`, reason: "", fields: [] });

// Fails `times` times, then succeeds.
function failing(times: number, error: Error): { work: () => Promise<string>; count: () => number } {
  let count = 0;
  return { count: () => count, work: () => (++count > times ? Promise.resolve("done") : Promise.reject(error)) };
}

test("what may pass is tried again, what cannot is not", async () => {
  for (const error of [callFailure(14), callFailure(8), new TransientError("503")]) {
    const { work, count } = failing(2, error);
    assert.equal(await withRetries(work, () => true), "done");
    assert.equal(count(), 3);
  }
  for (const error of [callFailure(5), callFailure(3), new Error("404")]) {
    const { work, count } = failing(2, error);
    await assert.rejects(withRetries(work, () => true), error);
    assert.equal(count(), 1);
  }
});

test("what nobody wants any more is not tried again", async () => {
  const { work, count } = failing(99, callFailure(8));
  let isWanted = true;
  setTimeout(() => { isWanted = false; }, 150);
  await assert.rejects(withRetries(work, () => isWanted), /code 8/);
  assert.ok(count() >= 2 && count() <= 3, `${count()}`);
});

test("of what is asked only the newest is heard", async () => {
  const newest = new LatestRequest();
  const heard: string[] = [];
  const ask = async (name: string, time_ms: number): Promise<void> => {
    const isWanted = newest.begin();
    await new Promise((resolve) => setTimeout(resolve, time_ms));
    if (isWanted()) heard.push(name);
  };
  await Promise.all([ask("slow", 60), ask("quick", 10)]);
  assert.deepEqual(heard, ["quick"]);
  assert.ok(newest.isPending);
  const dropped = ask("put away", 10);
  newest.drop();
  assert.equal(newest.isPending, false);
  await dropped;
  assert.deepEqual(heard, ["quick"]);
});

test("work that is asked for while it is done is done once more, not twice", async () => {
  let runs = 0;
  const latest = new CoalescedTask(async () => {
    ++runs;
    await new Promise((resolve) => setTimeout(resolve, 20));
  });
  for (let i = 0; i < 5; ++i) latest.request();
  await new Promise((resolve) => setTimeout(resolve, 100));
  assert.equal(runs, 2);
});
