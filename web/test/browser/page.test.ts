/** The page in a real browser, with the real program behind it. */
import type { ChildProcess } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import type { Browser, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import type { Command } from '../../src/protocol';
import { does, launch, path, patience, role, start, stop } from './program';
import { Relay } from './relay';

const picture = path('../../../build/page.png');

let baton: ChildProcess;
let browser: Browser;
let page: Page;
let url = '';
let relay: Relay; // between the page that drives at first and the program
const complaints: string[] = [];
const sent: Command[] = []; // by the page that drives at first

/** Counts the shaders that are made before the page asks for the driver's seat, and afterwards. */
function countShaders(): void {
  const counts = { before: 0, after: 0 };
  let asked = false;
  Object.assign(window, { shaders: counts });
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (data): void {
    asked ||= String(data).includes('"drive"');
    send.call(this, data);
  };
  const link = WebGL2RenderingContext.prototype.linkProgram;
  WebGL2RenderingContext.prototype.linkProgram = function (made): void {
    ++counts[asked ? 'after' : 'before'];
    link.call(this, made);
  };
}

async function open(width: number, height: number, at: string): Promise<Page> {
  const opened = await browser.newPage({ viewport: { width, height } });
  await opened.addInitScript(countShaders);
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

const com = async (axis: number): Promise<number> =>
  parseFloat((await page.locator('#com').innerText()).split(/\s+/)[axis]!);
const comX = (): Promise<number> => com(0);
const comY = (): Promise<number> => com(1);

beforeAll(async () => {
  ({ run: baton, url } = await start('--world room --on ideal'));
  browser = await launch();
  relay = await Relay.to(url);
  page = await open(1280, 800, relay.url);
  await role(page, 'driver');
});

afterAll(async () => {
  await browser?.close();
  relay?.close();
  await stop(baton);
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
  for (const key of ['w', 'a', 'd', 'h', 'Backspace', 'Space', 'Control']) await page.keyboard.up(key);
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
  await atRest();
});

/** The robot rests, and the panels say so. */
async function atRest(): Promise<void> {
  await does(page, 'rest');
  await page.locator('#segment', { hasText: 'at rest' }).waitFor(patience);
}

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
    await does(page, 'retracing');
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
        (await limit.isVisible()) && /^only part of the way: left foot: .*reach/.test(await limit.innerText()),
    );
    while (!(await page.locator('#stuck').isVisible())) {
      await page.waitForTimeout(400);
      await page.keyboard.up('a');
      await page.waitForTimeout(200);
      await page.keyboard.down('a');
    }
    await shown('#stuck', /^The left foot was refused three times in a row\. Another part may move/);
    await page.keyboard.up('a');
    await hold(key('Backspace'), () => page.locator('#stuck').isHidden());
    await page.keyboard.up('Backspace');
    await atRest();
  });

  test('with nothing to retrace the page does not say that it retraces', async () => {
    await page.keyboard.down('Backspace');
    await shown('#refusal', /^nothing left to retrace/);
    expect(await page.locator('#recall').isVisible()).toBe(false);
    expect(await page.locator('body').getAttribute('data-state')).toBe('rest');
    await page.keyboard.up('Backspace');
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
    await does(page, 'waiting');
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

describe('stop', () => {
  beforeEach(retraceAll);

  /** Takes hold of the robot's stick so that it walks to the right, until it does. */
  async function walks(): Promise<void> {
    await page.keyboard.press('5');
    await hold(key('d'), moreThan(await left()));
    await does(page, 'moving');
  }

  /** The robot rests and goes on resting. */
  async function staysAtRest(): Promise<void> {
    await atRest();
    const [rest, motions] = [await comY(), await left()];
    await page.waitForTimeout(700);
    await atRest();
    expect([await comY(), await left()]).toEqual([rest, motions]);
  }

  test('what is held beside it moves nothing afterwards, until it was let go of once', async () => {
    for (const [press, release] of [button('#stop'), key('Space')]) {
      await walks();
      await press();
      await does(page, 'stopping');
      await atRest();
      await release();
      await staysAtRest(); // D is still down
      await page.keyboard.up('d');
      await walks();
      await page.keyboard.up('d');
      await atRest();
    }
  });

  test('a key that goes down beside it moves nothing afterwards, either', async () => {
    await page.keyboard.down('Space');
    await expect.poll(() => sent.at(-1)!.recall, patience).toBe('stop');
    await page.keyboard.down('d');
    await page.keyboard.up('Space');
    await shown('#hint', /^Release all keys/);
    await staysAtRest();
    await page.keyboard.up('d');
    await walks();
  });

  test('lasts until the robot rests, though it is only tapped', async () => {
    await walks();
    const from = sent.length;
    await page.keyboard.press('Space');
    await does(page, 'stopping');
    await atRest();
    await expect.poll(() => sent.at(-1)!.recall, patience).toBe('none');
    const asked = sent.slice(from).map(({ recall }) => recall);
    expect(asked.slice(asked.indexOf('stop'), asked.lastIndexOf('stop') + 1)).not.toContain('none');
    expect(asked.filter((recall) => recall === 'stop').length).toBeGreaterThan(1);
    await page.keyboard.up('d');
  });

  test('Space stops whatever is open, focused or held, and presses nothing', async () => {
    const box = page.locator('#hold');
    const focus = (id: string) => (): Promise<void> => page.focus(id);
    const help = page.locator('#help');
    const situations: [what: string, before: () => Promise<unknown>, after: () => Promise<unknown>][] = [
      ['nothing', async () => {}, async () => {}],
      ['help', () => page.keyboard.press('?'), () => page.keyboard.press('?')],
      ['a button', focus('#take'), async () => {}],
      ['a box', focus('#hold'), async () => {}],
      ['a slider', focus('[data-lift="0"]'), async () => {}],
      ['Control', () => page.keyboard.down('Control'), () => page.keyboard.up('Control')],
      ['D', () => page.keyboard.down('d'), () => page.keyboard.up('d')],
    ];
    for (const [what, before, after] of situations) {
      await before();
      await page.keyboard.down('Space');
      await page.keyboard.down('Space'); // it repeats
      await expect.poll(() => sent.at(-1)!.recall, { ...patience, message: what }).toBe('stop');
      expect(await help.isVisible(), what).toBe(what === 'help');
      await page.keyboard.up('Space');
      await atRest();
      await expect.poll(() => sent.at(-1)!.recall, { ...patience, message: what }).toBe('none');
      expect(await help.isVisible(), what).toBe(what === 'help');
      expect(await box.isChecked(), what).toBe(true);
      await role(page, 'driver');
      await after();
    }
    await page.locator('#hold').blur();
  });

  test('who opens help lets go of everything', async () => {
    await walks();
    await page.keyboard.press('?');
    await staysAtRest(); // D is still down
    await hold(button('#help [data-way="stop"]'), async () => sent.at(-1)!.recall === 'stop');
    await page.mouse.up();
    await page.keyboard.press('?');
    await page.keyboard.up('d');
  });
});

test('help opens and closes with its key', async () => {
  await page.keyboard.press('?');
  await page.waitForSelector('#help', { state: 'visible', ...patience });
  await page.keyboard.press('?');
  await page.waitForSelector('#help', { state: 'hidden', ...patience });
});

test('a page that drives makes no shader: it would be silent for so long, and its stick would not count', async () => {
  await retraceAll();
  await page.keyboard.press('3');
  await hold(key('w'), async () => /^reach/.test(await page.locator('#segment').innerText()));
  await page.keyboard.up('w');
  await atRest();
  await page.keyboard.press('2');
  await page.keyboard.press('l');
  await page.locator('#phase', { hasText: 'single support' }).waitFor(patience);
  await page.keyboard.press('Space');
  await atRest();
  const { before, after } = await page.evaluate(
    () => (window as unknown as { shaders: { before: number; after: number } }).shaders,
  );
  expect(before).toBeGreaterThan(5);
  expect(after).toBe(0);
});

test('nothing in the page complains', () => {
  expect(complaints).toEqual([]);
});
