/** The page: reads keys and pad, sends the stick's command, shows what comes back. */
import { Hud } from './hud';
import { Markers } from './markers';
import { type Command, type Model, type State } from './protocol';
import { Robot } from './scene';
import { Signal } from './signal';
import { Link } from './socket';
import { sameCommand, Stick } from './stick';
import { View } from './view';

const sendPeriod = 33; // period of commands while driving, which serve as heartbeat [ms]

const stick = new Stick();
const signal = new Signal();
let view: View | null = null;
let state: State | null = null;
let drew: State | null = null;
let wantsToDrive = true; // the first page opened drives

const link = new Link(`ws://${location.host}/ws`);
const hud = new Hud(stick, {
  takeOrLeave() {
    wantsToDrive = state?.role !== 'driver';
    link.send({ type: wantsToDrive ? 'drive' : 'release' });
  },
  toggleFollow,
  letGo,
  moved: () => send(false),
  damp,
});

/** Whoever sees the robot may let its motors only brake, whoever drives. */
function damp(): void {
  if (state?.damps) link.send({ type: 'damp' });
}

function toggleFollow(): void {
  if (!view) return;
  view.follow = !view.follow;
  hud.following(view.follow);
}

// --- the stick ---------------------------------------------------------------------------------------

let sent: Command | null = null;

function currentPad(): Gamepad | null {
  const pads = navigator.getGamepads?.() ?? [];
  return pads.find((pad) => pad?.connected && pad.mapping === 'standard') ?? null;
}

function send(always: boolean): void {
  const away = document.hidden || !document.hasFocus();
  const command = stick.command(away ? null : currentPad());
  if (state?.role !== 'driver') return;
  if (always || !sameCommand(sent, command)) link.send({ type: 'command', ...command });
  sent = command;
}

function describePads(): void {
  const pads = (navigator.getGamepads?.() ?? []).filter((pad) => pad?.connected);
  const known = pads.find((pad) => pad?.mapping === 'standard');
  if (known) hud.pad(`pad: ${known.id}`);
  else hud.pad(pads[0] ? `the browser does not know the layout of this pad: ${pads[0].id}` : '');
}

function letGo(): void {
  stick.letGo();
  send(false);
}

/** Space stops, whatever is open, focused or held, and never activates a button. */
function stopKey(event: KeyboardEvent): void {
  event.preventDefault();
  event.stopImmediatePropagation();
  if (event.type === 'keydown') stick.press('Space');
  else stick.keyboard.release('Space');
  send(false);
}

addEventListener(
  'keydown',
  (event) => {
    if (event.code === 'Space') return stopKey(event);
    if (event.code === 'Digit0' && !event.repeat) return damp();
    if (event.ctrlKey || event.metaKey || event.altKey) return letGo(); // browser shortcuts
    const help = event.key === '?' || event.code === 'Slash';
    if (document.querySelector('dialog[open]') && !help) return;
    stick.keyboard.shift(event.shiftKey);
    if (help) {
      if (!event.repeat) hud.toggleHelp();
    } else if (event.code === 'KeyC') {
      if (!event.repeat) toggleFollow();
    } else if (!event.repeat && !stick.press(event.code)) {
      return;
    }
    if (event.code !== 'Tab') event.preventDefault();
    send(false);
  },
  { capture: true },
);
addEventListener(
  'keyup',
  (event) => {
    if (event.code === 'Space') return stopKey(event);
    stick.keyboard.shift(event.shiftKey);
    stick.keyboard.release(event.code);
    send(false);
  },
  { capture: true },
);
addEventListener('blur', letGo);
addEventListener('pagehide', letGo);
document.addEventListener('visibilitychange', () => {
  if (document.hidden) letGo();
});
addEventListener('gamepadconnected', describePads);
addEventListener('gamepaddisconnected', describePads);
setInterval(() => {
  if (signal.lost(performance.now())) {
    letGo(); // no driving without a current view
    hud.noSignal();
  }
  send(true);
}, sendPeriod);

// --- the program -------------------------------------------------------------------------------------

async function show(): Promise<void> {
  const model = (await (await fetch('./model.json')).json()) as Model;
  const made = new View(document.getElementById('view') as HTMLCanvasElement, model.size);
  const robot = new Robot(model, made.software ? 1 : 8);
  const markers = new Markers(model.size);
  made.scene.add(robot.root, markers.root);
  hud.describe(model);
  hud.following(made.follow);
  markers.showAll(made.camera);
  made.warmUp();
  markers.root.visible = false;
  view = made;

  const draw = (now: number): void => {
    requestAnimationFrame(draw);
    if (state) {
      if (state !== drew) {
        robot.pose(state.bodies);
        robot.highlight(state.role === 'driver' ? stick.guide : state.guide);
        hud.show(state, now);
        if (!drew) made.reset(robot.position('trunk'));
        drew = state;
      }
      made.watch(robot.position('trunk'));
      markers.show(state, made.camera);
    }
    made.draw(now, state?.state === 'rest');
  };
  requestAnimationFrame(draw);
}

let lost = false;
link.onOpen = () => {
  if (lost) return location.reload(); // robot, world or page may have changed
  if (wantsToDrive) link.send({ type: 'drive' });
};
link.onState = (newest) => {
  const newly = newest.role === 'driver' && state?.role !== 'driver';
  state = newest;
  signal.heard(performance.now());
  hud.activity(newest.state);
  if (newly) stick.letGo();
  if (newest.state === 'rest' || newest.state === 'fallen') stick.rests();
  if (newest.role === 'driver' && newest.recall !== 'none') stick.goingBack(newest.contact);
  hud.cover('');
};
link.onClose = () => {
  lost = true;
  state = null;
  signal.closed();
  stick.letGo();
  hud.disconnected();
};
link.onError = (why) => console.warn(`the program says: ${why}`);

show().then(
  () => link.open(),
  (error: unknown) => hud.cover(`The page cannot show the robot: ${String(error)}`),
);
