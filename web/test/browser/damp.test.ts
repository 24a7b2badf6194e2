/** A robot at the other end of a connection: its faults are on the page, and it is damped from there. */
import { spawn, type ChildProcess } from 'node:child_process';
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { launch, path, patience, program, role, start, stop } from './program';

let browser: Browser;
let robot: ChildProcess;
let run: ChildProcess;

beforeAll(async () => {
  browser = await launch();
});

afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
  await stop(run);
  robot?.kill('SIGKILL');
});
afterAll(() => browser?.close());

/** Starts a robot's end; the address is the one that it prints. */
function robotsEnd(): Promise<string> {
  robot = spawn(program, 'robot --sim --world flat --real-time --listen 127.0.0.1:0'.split(' '));
  return new Promise((resolve, reject) => {
    robot.stdout!.on('data', (text: Buffer) => resolve(/tcp:\/\/[\d.]+:\d+/.exec(text.toString())![0]));
    robot.on('exit', (code) => reject(new Error(`the robot's end ended (${code})`)));
  });
}

test('whoever watches damps a robot, whatever is open', async () => {
  const started = await start(`--world flat --on ${await robotsEnd()}`);
  run = started.run;
  const ended = new Promise((resolve) => run.on('exit', resolve));
  const said = new Promise((resolve) => {
    robot.stderr!.on('data', (text: Buffer) => {
      if (text.toString().includes('damped: asked for by the driver: by the page')) resolve(true);
    });
  });
  const driver = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await driver.goto(started.url);
  await role(driver, 'driver');
  const watcher = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await watcher.goto(started.url);
  await role(watcher, 'watcher');
  await watcher.locator('#damp').waitFor(patience); // it can be seen
  await watcher.screenshot({ path: path('../../../build/damp.png') });
  await watcher.keyboard.press('?');
  await watcher.locator('#damp-key').waitFor(patience);
  await watcher.keyboard.press('0');
  expect(await said).toBe(true);
  expect(await ended).toBe(1); // the run is over: the robot follows no longer
});

test('a fault that the robot reports is said until it is over', async () => {
  const started = await start(`--world flat --on ${await robotsEnd()}`);
  run = started.run;
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await page.goto(started.url);
  await role(page, 'driver');
  robot.stdin!.write('f left knee: too hot\n');
  const notice = page.getByText('The robot reports a fault: left knee: too hot.');
  await notice.waitFor(patience);
  await page.screenshot({ path: path('../../../build/fault.png') });
  robot.stdin!.write('f\n');
  await notice.waitFor({ ...patience, state: 'hidden' });
});
