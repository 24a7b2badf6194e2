/** The first moments of a page that drives. */
import type { ChildProcess } from 'node:child_process';
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { launch, role, start, stop } from './program';

const silence = 250; // for which the program lets go [ms]

let baton: ChildProcess;
let browser: Browser;
let url = '';

beforeAll(async () => {
  ({ run: baton, url } = await start('--world room --on ideal'));
  browser = await launch();
});

afterAll(async () => {
  await browser?.close();
  await stop(baton);
});

/** Notes when the page says something, from when it asks for the driver's seat. */
function note(): void {
  const said: number[] = [];
  Object.assign(window, { said });
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (data): void {
    if (said.length > 0 || String(data).includes('"drive"')) said.push(performance.now());
    send.call(this, data);
  };
}

test('is not silent for so long that the first motion would be let go of', async () => {
  for (let load = 0; load < 2; ++load) {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    await page.addInitScript(note);
    await page.goto(url);
    await role(page, 'driver');
    await page.keyboard.down('d');
    await page.waitForTimeout(1500);
    await page.keyboard.up('d');
    const said = await page.evaluate(() => (window as unknown as { said: number[] }).said);
    expect(said.length).toBeGreaterThan(15);
    expect(Math.max(...said.slice(1).map((time, i) => time - said[i]!))).toBeLessThan(silence);
    await page.close();
  }
});
