/** The page in a real browser, with the real program behind it. */
import { spawn, type ChildProcess } from 'node:child_process';
import { existsSync, mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium, type Browser, type Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import type { Command } from '../../src/protocol';
import { Relay } from './relay';

const path = (relative: string): string => fileURLToPath(new URL(relative, import.meta.url));
const program = process.env.BATON ?? path('../../../build/release/baton');
const picture = path('../../../build/page.png');
const patience = { timeout: 60_000 };

let baton: ChildProcess;
let browser: Browser;
let page: Page;
let url = '';
let relay: Relay; // between the page that drives at first and the program
const complaints: string[] = [];
const sent: Command[] = []; // by the page that drives at first

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

async function open(width: number, height: number, at: string): Promise<Page> {
  const opened = await browser.newPage({ viewport: { width, height } });
  opened.on('pageerror', (error) => complaints.push(String(error)));
  opened.on('console', (message) => {
    if (message.type() === 'error') complaints.push(message.text());
  });
  opened.on('websocket', (socket) => {
    socket.on('framesent', ({ payload }) => {
      const message = JSON.parse(String(payload)) as { type: string } & Command;
      if (message.type === 'command' && (!page || opened === page)) sent.push(message);
    });
  });
  await opened.goto(at);
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
  relay = await Relay.to(url);
  page = await open(1280, 800, relay.url);
  await role(page, 'driver');
});

afterAll(async () => {
  await browser?.close();
  relay?.close();
  if (baton && baton.exitCode === null) {
    const ended = new Promise((resolve) => baton.on('exit', resolve));
    baton.kill('SIGINT');
    await ended;
  }
});

type Grip = [press: () => Promise<void>, release: () => Promise<void>];
const key = (name: string): Grip => [() => page.keyboard.down(name), () => page.keyboard.up(name)];
const button = (id: string): Grip => [
  () => page.hover(id).then(() => page.mouse.down()),
  () => page.mouse.up(),
];

/**
 * Holds a key or a button until something has come about; the caller lets go. Where the machine is so busy that the page
 * is silent for a moment, it does not count before everything was let go: so it is pressed anew now and then.
 */
async function hold([press, release]: Grip, done: () => Promise<boolean>): Promise<void> {
  const began = performance.now();
  for (;;) {
    await press();
    for (let look = 0; look < 30; ++look) {
      if (await done()) return;
      await page.waitForTimeout(100);
    }
    if (performance.now() - began > patience.timeout) {
      throw new Error(`in vain: ${done}; the page says: ${await page.locator('body').innerText()}`);
    }
    await release();
    await page.waitForTimeout(200);
  }
}

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
  await hold(key('w'), async () => (await comX()) > before + 0.01);
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

const moreThan = (motions: number) => async (): Promise<boolean> => (await left()) > motions;
const lessThan = (motions: number) => async (): Promise<boolean> => (await left()) < motions;

/** Back to the start: at rest, with nothing left to retrace; let go of before, the robot would stop on its way. */
async function retraceAll(): Promise<void> {
  await hold(key('Backspace'), () =>
    page.evaluate(
      () =>
        document.getElementById('left')!.textContent === '' &&
        document.getElementById('segment')!.textContent === 'at rest',
    ),
  );
  await page.keyboard.up('Backspace');
  await atRest();
}

describe('the ways back', () => {
  beforeEach(retraceAll);

  /** To the right, where the floor is wide, from one rest to the next. */
  async function walk(rests: number): Promise<number> {
    await page.keyboard.press('5');
    for (let k = 0; k < rests; ++k) {
      const motions = await left();
      await hold(key('d'), moreThan(motions));
      await page.keyboard.up('d');
      await atRest();
    }
    return comY();
  }

  /** The way back is over: the robot comes to rest and stays there. */
  async function hasEnded(): Promise<void> {
    await page.waitForSelector('#recall', { state: 'hidden', ...patience });
    await atRest();
    await page.waitForSelector('.ways .on', { state: 'detached', ...patience });
    const [rest, motions] = [await comY(), await left()];
    await page.waitForTimeout(700);
    expect(await comY()).toBe(rest);
    expect(await left()).toBe(motions);
  }

  test('Backspace takes the robot back, while it is held', async () => {
    const start = await comY();
    const there = await walk(6);
    expect(there).toBeLessThan(start - 0.01);
    const motions = await left();
    await hold(key('Backspace'), async () => /^retracing: /.test(await page.locator('#recall').innerText()));
    await page.waitForSelector('#retrace.on', patience);
    await hold(key('Backspace'), lessThan(motions - 2));
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
      await hold(button('#retrace'), lessThan(motions));
      await end();
      await hasEnded();
      await page.mouse.up();
    }
  });

  test('Home goes home while its key or its button is held', async () => {
    for (const home of [key('h'), button('#home')]) {
      await page.keyboard.press('1');
      await hold(key('a'), moreThan(await left()));
      await page.keyboard.up('a'); // feet apart
      await atRest();
      const motions = await left();
      await hold(home, async () => /^home: /.test(await page.locator('#recall').innerText()));
      await page.waitForSelector('#home.on', patience);
      await hold(home, moreThan(motions));
      await home[1]();
      await hasEnded();
    }
  });

  test('a motion that goes only a part of the way says why, and three refusals what leads out', async () => {
    await page.keyboard.press('1');
    const limit = page.locator('#limit');
    await hold(
      key('a'), // outward, as far as it goes
      async () =>
        (await limit.isVisible()) && /^as far as it goes: left foot: .*reach/.test(await limit.innerText()),
    );
    while (!(await page.locator('#stuck').isVisible())) {
      await page.waitForTimeout(400);
      await page.keyboard.up('a');
      await page.waitForTimeout(200);
      await page.keyboard.down('a');
    }
    await shown('#stuck', /^Nothing goes from here\. Retrace \(Backspace\) or Home \(H\)/);
    await page.keyboard.up('a');
    await hold(key('Backspace'), () => page.locator('#stuck').isHidden());
    await page.keyboard.up('Backspace');
    await atRest();
  });
});

test('an impossible wish is refused in plain words', async () => {
  await page.keyboard.press('1');
  const refusal = page.locator('#refusal', { hasText: /^left foot: / });
  await hold(key('d'), () => refusal.isVisible()); // the left foot, onto the right one
  await page.keyboard.up('d');
  expect(await refusal.innerText()).toMatch(/^left foot: [a-z ]+.*\(.+, at (most|least) .+\)$/);
});

test('a second page watches, and drives once the first one lets it', async () => {
  const second = await open(950, 500, url);
  await role(second, 'watcher');
  await second.locator('#role', { hasText: 'watching' }).waitFor(patience);
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

describe('nobody asks for more', () => {
  beforeEach(retraceAll); // the walks to the right do not add up to the edge of the stage

  const centred = (command: Command): boolean =>
    command.axes.every((axis) => axis === 0) && command.lift.every((lift) => lift === 0);

  test('the stick is sent steadily, also when nothing changes', async () => {
    await page.keyboard.down('d');
    const from = sent.length;
    await page.waitForTimeout(2000);
    const held = sent.slice(from);
    await page.keyboard.up('d');
    expect(held.filter(({ axes }) => axes[1] === -1).length).toBeGreaterThanOrEqual(20); // 10 Hz at least
    await atRest();
  });

  test('a page that is hidden, left, or loses the keyboard lets go of everything at once', async () => {
    await page.keyboard.press('5');
    for (const leave of [
      () => {
        Object.defineProperty(document, 'hidden', { configurable: true, get: () => true });
        document.dispatchEvent(new Event('visibilitychange'));
        Reflect.deleteProperty(document, 'hidden');
      },
      () => window.dispatchEvent(new Event('pagehide')),
      () => window.dispatchEvent(new Event('blur')),
    ]) {
      await page.keyboard.down('d');
      await expect.poll(() => centred(sent.at(-1)!), patience).toBe(false);
      await page.evaluate(leave);
      await expect.poll(() => centred(sent.at(-1)!), patience).toBe(true);
      await page.waitForTimeout(200);
      expect(centred(sent.at(-1)!)).toBe(true); // though the key is still down
      await page.keyboard.up('d');
    }
    await atRest();
  });

  test('a network that stalls counts as letting go, and the page says so', async () => {
    await page.keyboard.press('5');
    await hold(key('d'), moreThan(await left()));
    relay.stall();
    const motions = await left();
    await page.locator('#role', { hasText: 'no signal' }).waitFor(patience);
    await shown('#hint', /^No signal from the program/);
    await page.waitForTimeout(5000);
    relay.flow();
    await role(page, 'driver');
    await page.waitForSelector('#hint', { state: 'hidden', ...patience });
    await atRest();
    const meanwhile = (await left()) - motions;
    expect(meanwhile).toBeLessThan(4); // a walk of more than 5 s takes many
    await page.waitForTimeout(700);
    expect(await left()).toBe(motions + meanwhile); // though the key is still down
    await page.keyboard.up('d');
    await hold(key('a'), moreThan(motions + meanwhile));
    await page.keyboard.up('a');
    await atRest();
  });
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
