/** A fall, as the page shows it. */
import type { ChildProcess } from 'node:child_process';
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { launch, path, patience, role, start, stop } from './program';

let browser: Browser;
let run: ChildProcess;

beforeAll(async () => {
  browser = await launch();
});

afterEach(() => stop(run));
afterAll(() => browser?.close());

test('a fall is shown until the page is left', async () => {
  const started = await start('--world flat --on sim --scenario tiles --times 12'); // stands, and cannot walk
  run = started.run;
  const ended = new Promise((resolve) => run.on('exit', resolve));
  const fall = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await fall.goto(started.url);
  await role(fall, 'driver');
  while ((await fall.locator('body').getAttribute('data-state')) !== 'fallen') {
    await fall.keyboard.up('w');
    await fall.waitForTimeout(100);
    await fall.keyboard.down('w');
    await fall.waitForSelector('body[data-state="fallen"]', { timeout: 3000 }).catch(() => {});
  }
  await fall.locator('#message.fallen', { hasText: /^The robot fell: / }).waitFor(patience);
  await fall.waitForTimeout(1500);
  expect(await fall.locator('body').getAttribute('data-state')).toBe('fallen');
  await role(fall, 'driver'); // it is heard, still
  expect(run.exitCode).toBe(null);
  await fall.screenshot({ path: path('../../../build/fallen.png') });
  await fall.close();
  expect(await ended).toBe(3);
});
