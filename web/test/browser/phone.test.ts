/** What of the page is in reach on a phone. */
import type { ChildProcess } from 'node:child_process';
import type { Browser, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import { does, launch, patience, start, stop } from './program';

let baton: ChildProcess;
let browser: Browser;
let url = '';
let phone: Page;

beforeAll(async () => {
  ({ run: baton, url } = await start('--world room --on ideal'));
  browser = await launch();
});

afterEach(() => phone.close());
afterAll(async () => {
  await browser?.close();
  await stop(baton);
});

/** Expects every element that is seen on the phone to lie on its screen, and the seat's row in its card. */
async function within(width: number, height: number): Promise<void> {
  const visible = await phone.locator('.card, #seat > :not([hidden]), #run button').all();
  for (const element of visible) {
    const box = await element.boundingBox();
    if (!box) continue; // hidden meanwhile: the seat was taken
    expect(Math.min(box.x, box.y)).toBeGreaterThanOrEqual(0);
    expect(box.x + box.width).toBeLessThanOrEqual(width);
    expect(box.y + box.height).toBeLessThanOrEqual(height);
  }
  const seat = (await phone.locator('#seat').boundingBox())!;
  const help = (await phone.locator('#help-button').boundingBox())!;
  expect(help.x + help.width).toBeLessThanOrEqual(seat.x + seat.width);
}

describe('on a phone', () => {
  for (const [width, height] of [
    [390, 844],
    [360, 640],
    [844, 390],
  ] as const) {
    test(`of ${width} × ${height} nothing covers anything, and help can be closed`, async () => {
      phone = await browser.newPage({ viewport: { width, height }, hasTouch: true, isMobile: true });
      await phone.goto(url);
      await does(phone, 'rest');
      await within(width, height);
      await phone.click('#take'); // the row of buttons is widest while nobody drives
      await phone.waitForFunction(
        () => document.querySelector('#role')?.textContent === 'nobody drives',
        null,
        patience,
      );
      await within(width, height);
      const covered = await phone.evaluate(() => {
        const boxes = [...document.querySelectorAll('.card')].map((card) => card.getBoundingClientRect());
        return boxes.some((a, i) =>
          boxes.slice(i + 1).some((b) => {
            const apart = a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
            return !apart;
          }),
        );
      });
      expect(covered).toBe(false);
      await phone.click('#help-button');
      await phone.waitForSelector('#help', { state: 'visible', ...patience });
      for (const name of ['Close', 'Stop']) {
        const box = (await phone.locator('#help button', { hasText: name }).boundingBox())!;
        expect(box.y + box.height).toBeLessThanOrEqual(height);
      }
      await phone.click('#help button >> text=Close');
      await phone.waitForSelector('#help', { state: 'hidden', ...patience });
    });
  }
});
