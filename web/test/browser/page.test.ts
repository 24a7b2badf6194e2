/** The page in a real browser, with the real program behind it. */
import { spawn, type ChildProcess } from 'node:child_process';
import { existsSync, mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium, type Browser, type Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';

const path = (relative: string): string => fileURLToPath(new URL(relative, import.meta.url));
const program = process.env.BATON ?? path('../../../build/release/baton');
const picture = path('../../../build/page.png');
const patience = { timeout: 60_000 };

let baton: ChildProcess;
let browser: Browser;
let page: Page;
let url = '';
const complaints: string[] = [];

/** Starts the program and returns the address that it prints. */
function start(): Promise<string> {
  if (!existsSync(program)) throw new Error(`there is no program ${program}: build it, or name it in $BATON`);
  const args = [
    'drive',
    '--world',
    'room',
    '--input',
    'page',
    '--on',
    'ideal',
    '--seconds',
    '300',
    '--port',
    '0',
  ];
  baton = spawn(program, args, { stdio: ['ignore', 'pipe', 'pipe'] });
  return new Promise((resolve, reject) => {
    let output = '';
    const listen = (text: Buffer): void => {
      output += text.toString();
      const found = /page at (http:\S+)/.exec(output);
      if (found) resolve(found[1]!);
    };
    baton.stdout!.on('data', listen);
    baton.stderr!.on('data', listen);
    baton.on('error', reject);
    baton.on('exit', (code) => reject(new Error(`the program ended (${code}): ${output}`)));
  });
}

async function open(width: number, height: number): Promise<Page> {
  const opened = await browser.newPage({ viewport: { width, height } });
  opened.on('pageerror', (error) => complaints.push(String(error)));
  opened.on('console', (message) => {
    if (message.type() === 'error') complaints.push(message.text());
  });
  await opened.goto(url);
  return opened;
}

const role = (of: Page, wanted: string): Promise<unknown> =>
  of.waitForFunction((name) => document.getElementById('role')!.dataset.role === name, wanted, patience);

const comX = (): Promise<number> =>
  page
    .locator('#com')
    .innerText()
    .then((text) => parseFloat(text));

beforeAll(async () => {
  url = await start();
  const args = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--no-first-run'];
  const quiet = [
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--disable-quic',
  ];
  const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
  browser = await chromium.launch({ executablePath, headless: true, args: [...args, ...quiet] });
  page = await open(1280, 800);
  await role(page, 'driver');
});

afterAll(async () => {
  await browser?.close();
  if (baton && baton.exitCode === null) {
    const ended = new Promise((resolve) => baton.on('exit', resolve));
    baton.kill('SIGINT');
    await ended;
  }
});

test('shows the robot', async () => {
  await page.waitForFunction(
    () => document.getElementById('cover')!.classList.contains('hidden'),
    null,
    patience,
  );
  expect(await page.locator('#names').innerText()).toMatch(/ in room$/);
  // What is seen where no panel lies, as colours.
  const shot = await page.screenshot({ clip: { x: 400, y: 100, width: 500, height: 500 } });
  const colours = await page.evaluate(
    async (data) => {
      const image = new Image();
      image.src = data;
      await image.decode();
      const pen = Object.assign(document.createElement('canvas'), { width: 500, height: 500 }).getContext(
        '2d',
      )!;
      pen.drawImage(image, 0, 0);
      const pixels = new Uint32Array(pen.getImageData(0, 0, 500, 500).data.buffer);
      return new Set(pixels).size;
    },
    `data:image/png;base64,${shot.toString('base64')}`,
  );
  expect(colours).toBeGreaterThan(500);
});

test('keys choose the part, and so do the buttons', async () => {
  const parts = ['left_foot', 'right_foot', 'left_hand', 'right_hand', 'trunk'];
  const chosen = (part: string): Promise<unknown> =>
    page.waitForSelector(`[data-part="${part}"][aria-pressed="true"]`, patience);
  for (const [i, part] of parts.entries()) {
    await page.keyboard.press(String(i + 1));
    await chosen(part);
  }
  await page.click('[data-part="left_hand"]');
  await chosen('left_hand');
});

test('W in trunk mode moves the robot forward', async () => {
  await page.keyboard.press('5');
  await page.waitForSelector('#hint', { state: 'hidden', ...patience }); // armed
  const before = await comX();
  await page.keyboard.down('w');
  const moved = (from: number): boolean =>
    parseFloat(document.getElementById('com')!.textContent!) > from + 0.01;
  await page.waitForFunction(moved, before, patience);
  mkdirSync(path('../../../build'), { recursive: true });
  await page.screenshot({ path: picture });
  await page.keyboard.up('w');
  await page.waitForFunction(
    () => document.getElementById('segment')!.textContent === 'at rest',
    null,
    patience,
  );
});

test('an impossible wish is refused in plain words', async () => {
  await page.keyboard.press('1');
  await page.keyboard.down('d'); // the left foot, onto the right one
  const refusal = page.locator('#refusal', { hasText: /^left foot: / });
  await refusal.waitFor({ state: 'visible', ...patience });
  await page.keyboard.up('d');
  expect(await refusal.innerText()).toMatch(/^left foot: [a-z ]+.*\(.+, at (most|least) .+\)$/);
});

test('a second page watches, and drives once the first one lets it', async () => {
  const second = await open(950, 500);
  await role(second, 'watcher');
  expect(await second.locator('#role').innerText()).toBe('watching');
  expect(await second.locator('#take').isVisible()).toBe(false);
  await page.bringToFront();
  await page.click('#take');
  await role(page, 'watcher');
  await second.bringToFront();
  await second.locator('#take').waitFor({ state: 'visible', ...patience });
  await second.click('#take');
  await role(second, 'driver');
  await second.close();
  await page.locator('#take').waitFor({ state: 'visible', ...patience });
  await page.click('#take');
  await role(page, 'driver');
});

test('help opens and closes with its key', async () => {
  await page.keyboard.press('h');
  await page.waitForSelector('#help', { state: 'visible', ...patience });
  await page.keyboard.press('h');
  await page.waitForSelector('#help', { state: 'hidden', ...patience });
});

test('nothing in the page complains', () => {
  expect(complaints).toEqual([]);
});
