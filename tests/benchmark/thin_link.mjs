// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A page behind a link of 1 Mbit/s while a dive is mapped at a camera's rate: how long after their records are made planes
// are drawn and an alert is on the screen. The link is a network namespace of its own; as root.
// node tests/benchmark/thin_link.mjs [RATE_HZ] (2)
import { spawnSync } from "node:child_process";
import { chmodSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import http from "node:http";
import path from "node:path";
import * as harness from "../browser/harness.mjs";
import { until } from "../browser/harness.mjs";

const RATE_HZ = process.argv[2] ?? "2";
const IMAGES = 60;
const TORN = { from: 35, to: 50 }; // images that are missing: an alert
const LINK = ["rate", "1mbit", "burst", "4kb", "latency", "100ms"];
const SPACE = "nadir-thin";
const [HERE, THERE] = ["10.213.7.1", "10.213.7.2"];
const HEADER = 16;
const TYPE = { hello: 1, alert: 4, planeColour: 9 };
const VERSION = 2;

function ip(...words) {
  const { status, stderr } = spawnSync("ip", words, { encoding: "utf8" });
  if (status !== 0) throw new Error(`ip ${words.join(" ")}: ${stderr}`);
}

function makeLink() {
  ip("netns", "add", SPACE);
  process.on("exit", () => spawnSync("ip", ["netns", "del", SPACE]));
  ip("link", "add", "thin0", "type", "veth", "peer", "name", "thin1", "netns", SPACE);
  ip("addr", "add", `${HERE}/30`, "dev", "thin0");
  ip("link", "set", "thin0", "up");
  ip("netns", "exec", SPACE, "ip", "addr", "add", `${THERE}/30`, "dev", "thin1");
  ip("netns", "exec", SPACE, "ip", "link", "set", "thin1", "up");
  ip("netns", "exec", SPACE, "ip", "link", "set", "lo", "up");
  for (const [space, device] of [[null, "thin0"], [SPACE, "thin1"]]) {
    const tc = ["tc", "qdisc", "add", "dev", device, "root", "tbf", ...LINK];
    const [program, ...words] = space === null ? tc : ["ip", "netns", "exec", space, ...tc];
    if (spawnSync(program, words).status !== 0) throw new Error("no tbf");
  }
}

/** When records come to a viewer on this machine: [[type, image or alert, milliseconds since 1970]]. */
function watch(port) {
  const seen = [];
  const request = http.request({ host: "127.0.0.1", port, path: "/feed", headers: {
    Origin: `http://127.0.0.1:${port}`, Connection: "Upgrade", Upgrade: "websocket", "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==" } });
  request.on("upgrade", (_, socket, head) => {
    const hello = Buffer.alloc(6 + HEADER + 16);
    hello.set([0x82, 0x80 | (HEADER + 16), 0, 0, 0, 0, TYPE.hello, VERSION]);
    socket.write(hello);
    let rest = head;
    socket.on("data", (more) => {
      rest = Buffer.concat([rest, more]);
      for (;;) {
        if (rest.length < 2) return;
        const short = rest[1] & 127;
        const begin = short < 126 ? 2 : short === 126 ? 4 : 10;
        if (rest.length < begin) return;
        const size = short < 126 ? short : short === 126 ? rest.readUInt16BE(2) : Number(rest.readBigUInt64BE(2));
        if (rest.length < begin + size) return;
        if (rest[0] === 0x89) socket.write(Buffer.concat([Buffer.from([0x8a, 0x80 | size, 0, 0, 0, 0]), rest.subarray(begin, begin + size)]));
        if (rest[0] === 0x82) seen.push([rest[begin], size >= HEADER + 8 ? Number(rest.readBigUInt64LE(begin + HEADER)) : 0, Date.now()]);
        rest = rest.subarray(begin + size);
      }
    });
    process.on("exit", () => socket.destroy());
  });
  request.end();
  return seen;
}

const median = (values) => [...values].sort((one, other) => one - other)[Math.floor(values.length / 2)];

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
harness.simulate(survey, "--scene", "pool", "--images", String(IMAGES), "--stereo", "--seed", "7");
for (const side of ["left", "right"]) {
  const images = path.join(survey, "images", side);
  readdirSync(images).sort().forEach((name, i) => {
    if (i >= TORN.from && i < TORN.to) rmSync(path.join(images, name));
  });
}
makeLink();
const program = path.join(folder, "chromium");
writeFileSync(program, `#!/bin/sh\nexec ip netns exec ${SPACE} ${process.env.NADIR_CHROMIUM ?? "/usr/bin/chromium"} "$@"\n`);
chmodSync(program, 0o755);
const browser = await harness.chromium({ program });
const port = await harness.freePort();
const run = await harness.replay(survey, path.join(folder, "dive"), port, "--rate", RATE_HZ, "--keep-serving", "--serve", `0.0.0.0:${port}`);
const made = watch(port);
const { page, read } = await harness.openPage(browser, port, undefined, harness.LANDSCAPE, `http://${HERE}:${port}/`);
// Every picture of the browser: what is on it by then.
await page.evaluate((images) => {
  window.shown = { from: Date.now(), planes: {}, alerts: [] };
  const look = () => {
    const now = Date.now();
    for (let image = 0; image < images; ++image) {
      if (window.nadir.hasPlane(image)) window.shown.planes[image] ??= now;
    }
    while (window.shown.alerts.length < window.nadir.alerts) window.shown.alerts.push(now);
    requestAnimationFrame(look);
  };
  look();
}, IMAGES);
await until("the end", read, ({ state }) => state?.finished === true, 180);
const shown = await page.evaluate(() => window.shown);
// What was there before the page is not news to it.
const news = (type) => new Map(made.filter((record) => record[0] === type && record[2] > shown.from).map(([, id, at]) => [id, at]));
const ofPlanes = [...news(TYPE.planeColour)].map(([image, at]) => (shown.planes[image] ?? Infinity) - at);
const ofAlerts = [...news(TYPE.alert)].map(([id, at]) => (shown.alerts[id] ?? Infinity) - at);
const [slowestPlane, slowestAlert] = [Math.max(...ofPlanes), Math.max(...ofAlerts)];
console.log(`${ofPlanes.length} planes at ${RATE_HZ} Hz over ${LINK.join(" ")}: drawn after ${median(ofPlanes)} ms in the median, ${slowestPlane} ms at most (bar 2000)`);
console.log(`${ofAlerts.length} alerts: on the screen after ${ofAlerts.join(", ")} ms (bar 500)`);
run.stop();
await browser.close();
process.exit(ofPlanes.length > 0 && ofAlerts.length > 0 && slowestPlane <= 2000 && slowestAlert <= 500 ? 0 : 1);
