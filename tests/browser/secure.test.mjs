// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The page under TLS and plain, on one port, by the name that tablets know.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import path from "node:path";
import test from "node:test";
import * as harness from "./harness.mjs";
import { until } from "./harness.mjs";

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
assert.deepEqual(harness.missing, [], "not there");

test("the page by a name", { timeout: 300_000 }, async (t) => {
  const [certificate, key] = ["page.pem", "page.key"].map((file) => path.join(folder, file));
  const made = spawnSync("openssl", [
    ..."req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=nadir".split(" "),
    ...["-addext", "subjectAltName=DNS:nadir.local", "-out", certificate, "-keyout", key],
  ]);
  assert.equal(made.status, 0, String(made.stderr));
  harness.simulate(survey, "--scene", "pool", "--images", "6", "--stereo");
  const port = await harness.freePort();
  const settings = ["--set", `serve.certificate=${certificate}`, "--set", `serve.key=${key}`];
  const run = await harness.replay(survey, path.join(folder, "dive"), port, "--keep-serving", ...settings);
  const browser = await harness.chromium({ more: ["--ignore-certificate-errors"] });
  t.after(async () => {
    run.stop();
    await browser.close();
  });

  for (const [scheme, feed] of [["https", "wss"], ["http", "ws"]]) {
    await t.test(`${scheme}: is whole, and can be installed only from https`, async () => {
      const page = await browser.newPage();
      const feeds = [];
      const errors = [];
      page.on("websocket", (socket) => feeds.push(socket.url()));
      page.on("pageerror", (error) => errors.push(error.message));
      page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
      await page.goto(`${scheme}://nadir.local:${port}/`);
      await until("finished", () => page.evaluate(() => window.nadir.state?.finished === true), Boolean, 60);
      const installs = await page.evaluate(
        async () => isSecureContext && (await navigator.serviceWorker.ready).active !== null,
      );
      assert.equal(installs, scheme === "https");
      assert.deepEqual(feeds, ["feed", "records?type=4"].map((path) => `${feed}://nadir.local:${port}/${path}`));
      assert.deepEqual(errors, []);
      await page.close();
    });
  }
});
