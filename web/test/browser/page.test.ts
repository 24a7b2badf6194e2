/** The page in a real browser, with the real program behind it. */
import { spawn, type ChildProcess } from 'node:child_process';
import { existsSync, mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium, type Browser, type Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';

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
    '600',
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

const com = async (axis: number): Promise<number> =>
  parseFloat((await page.locator('#com').innerText()).split(/\s+/)[axis]!);
const comX = (): Promise<number> => com(0);
const comY = (): Promise<number> => com(1);

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

afterEach(async () => {
  for (const key of ['w', 'a', 'd', 'h', 'Backspace']) await page.keyboard.up(key);
  await page.mouse.up();
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

const atRest = (): Promise<unknown> =>
  page.waitForFunction(
    () => document.getElementById('segment')!.textContent === 'at rest',
    null,
    patience,
  );

const shown = (id: string, words: RegExp): Promise<void> =>
  page.locator(id, { hasText: words }).waitFor({ state: 'visible', ...patience });

/** How many motions can be retraced. */
const left = (): Promise<number> => page.locator('#left').innerText().then(Number);

const motionsMade = (from: number): Promise<unknown> =>
  page.waitForFunction((n) => Number(document.getElementById('left')!.textContent) > n, from, patience);
const motionsRetraced = (from: number): Promise<unknown> =>
  page.waitForFunction((n) => Number(document.getElementById('left')!.textContent) < n, from, patience);

describe('the ways back', () => {
  /** To the right, where the floor is wide. */
  async function walk(motions: number): Promise<number> {
    await page.keyboard.press('5');
    await page.keyboard.down('d');
    await motionsMade(motions - 1);
    await page.keyboard.up('d');
    await atRest();
    return comY();
  }

  /** The way back is over: the robot comes to rest and stays there. */
  async function hasEnded(): Promise<void> {
    await page.waitForSelector('#recall', { state: 'hidden', ...patience });
    await atRest();
    expect(await page.locator('.ways .on').count()).toBe(0);
    const [rest, motions] = [await comY(), await left()];
    await page.waitForTimeout(700);
    expect(await comY()).toBe(rest);
    expect(await left()).toBe(motions);
  }

  /** Back to the start, where nothing is left to retrace. */
  async function retraceAll(): Promise<void> {
    await page.keyboard.down('Backspace');
    await page.waitForFunction(() => document.getElementById('left')!.textContent === '', null, patience);
    await shown('#refusal', /^nothing left to retrace$/);
    await page.keyboard.up('Backspace');
    await atRest();
  }

  beforeEach(retraceAll);

  test('Backspace takes the robot back, while it is held', async () => {
    const start = await comY();
    const there = await walk(8);
    expect(there).toBeLessThan(start - 0.01);
    const motions = await left();
    await page.keyboard.down('Backspace');
    await shown('#recall', /^retracing: /);
    await page.waitForSelector('#retrace.on', patience);
    await motionsRetraced(motions - 2);
    await page.keyboard.up('Backspace');
    await hasEnded();
    expect(await comY()).toBeGreaterThan(there);
    expect(await left()).toBeGreaterThan(0);
    await retraceAll();
    expect(await comY()).toBeCloseTo(start, 2);
  });

  test('the button takes it back while it is pressed, the pointer on it, and the page in use', async () => {
    await walk(5);
    for (const end of [
      () => page.mouse.up(),
      () => page.mouse.move(640, 300), // off the button, still pressed
      () => page.evaluate(() => window.dispatchEvent(new Event('blur'))),
    ]) {
      const motions = await left();
      await page.hover('#retrace');
      await page.mouse.down();
      await motionsRetraced(motions);
      await end();
      await hasEnded();
      await page.mouse.up();
    }
  });

  test('Home goes home while its key or its button is held', async () => {
    for (const [press, release] of [
      [() => page.keyboard.down('h'), () => page.keyboard.up('h')],
      [() => page.hover('#home').then(() => page.mouse.down()), () => page.mouse.up()],
    ] as const) {
      await page.keyboard.press('1');
      await page.keyboard.down('a');
      await motionsMade(await left());
      await page.keyboard.up('a'); // feet apart
      await atRest();
      const motions = await left();
      await press();
      await shown('#recall', /^home: /);
      await page.waitForSelector('#home.on', patience);
      await motionsMade(motions);
      await release();
      await hasEnded();
    }
  });

  test('a motion that goes only a part of the way says why, and three refusals what leads out', async () => {
    await page.keyboard.press('1');
    const limit = page.waitForFunction(
      () => {
        const note = document.getElementById('limit')!;
        return !note.hidden && /^as far as it goes: left foot: .*reach/.test(note.textContent!);
      },
      null,
      patience,
    );
    await page.keyboard.down('a'); // outward, as far as it goes
    await limit;
    while (!(await page.locator('#stuck').isVisible())) {
      await page.waitForTimeout(400);
      await page.keyboard.up('a');
      await page.waitForTimeout(200);
      await page.keyboard.down('a');
    }
    await shown('#stuck', /^Nothing goes from here\. Retrace \(Backspace\) or Home \(H\)/);
    await page.keyboard.up('a');
    await page.keyboard.down('Backspace');
    await page.waitForSelector('#stuck', { state: 'hidden', ...patience });
    await page.keyboard.up('Backspace');
    await atRest();
  });
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
  await page.keyboard.press('?');
  await page.waitForSelector('#help', { state: 'visible', ...patience });
  await page.keyboard.press('?');
  await page.waitForSelector('#help', { state: 'hidden', ...patience });
});

test('nothing in the page complains', () => {
  expect(complaints).toEqual([]);
});
