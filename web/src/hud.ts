/** The panels around the view. */
import { colours } from './markers';
import { inWords, parts, type Activity, type Model, type Part, type Recall, type State, type Value } from './protocol';
import { recallText, stuckText } from './recall';
import { limitText, RefusalLog } from './refusals';
import type { Stick } from './stick';

const axisNames = ['forward', 'left', 'up', 'roll', 'pitch', 'yaw'];
const axisKeys = ['W S', 'A D', 'R F', '→ ←', '↑ ↓', 'Q E'];
const freshFor = 2500; // time a refusal or a limit stays prominent [ms]

function element<T extends HTMLElement = HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

function text(id: string, content: string): void {
  const target = element(id);
  if (target.textContent !== content) target.textContent = content;
}

/** Shows a note, or hides it if empty. */
function note(id: string, content: string): void {
  text(id, content);
  element(id).hidden = content === '';
}

const millimetre = (value: Value): string =>
  value === null ? '–' : (Math.round(1e3 * value) / 1e3 + 0).toFixed(3);
const metres = (values: Value[]): string => `${values.map(millimetre).join('  ')} m`;

export interface Actions {
  takeOrLeave(): void;
  toggleFollow(): void;
  letGo(): void;
  moved(): void; // the stick was moved by a button
  damp(): void;
}

export class Hud {
  private readonly buttons: Map<Part, HTMLButtonElement>;
  private readonly bars: HTMLElement[];
  private readonly sliders: HTMLInputElement[];
  private readonly refusals = new RefusalLog();
  private refusedAt = -Infinity;
  private limitUntil = -Infinity;

  constructor(
    private readonly stick: Stick,
    private readonly actions: Actions,
  ) {
    this.bars = axisNames.map((name, i) => this.addAxis(name, axisKeys[i]!));
    this.sliders = [...document.querySelectorAll<HTMLInputElement>('[data-lift]')];
    this.buttons = new Map(
      parts.map((part) => [part, document.querySelector<HTMLButtonElement>(`[data-part="${part}"]`)!]),
    );
    for (const [part, button] of this.buttons) {
      button.onclick = () => {
        stick.guide = part;
        button.blur(); // Space is a key of the stick
      };
    }
    this.sliders.forEach((slider, foot) => {
      slider.oninput = () => (stick.lift[foot] = Number(slider.value));
      slider.onchange = () => slider.blur();
    });
    const hold = element<HTMLInputElement>('hold');
    hold.onchange = () => {
      stick.gamepad.needsHold = hold.checked;
      hold.blur();
    };
    for (const button of document.querySelectorAll<HTMLButtonElement>('[data-way]')) this.whilePressed(button);
    this.onClick('take', actions.takeOrLeave);
    this.onClick('follow', actions.toggleFollow);
    this.onClick('help-button', () => this.toggleHelp());
    this.onClick('damp', actions.damp);
    const shown = { support: 'support polygon', com: 'COM', zmp: 'ZMP', dcm: 'DCM', goal: 'goal' };
    for (const [key, name] of Object.entries(shown)) {
      const item = element('legend').appendChild(document.createElement('li'));
      item.appendChild(document.createElement('i')).style.background = colours[key as keyof typeof colours];
      item.append(name);
    }
  }

  describe(model: Model): void {
    text('names', `${inWords(model.robot)} in ${inWords(model.world)}`);
    document.title = `baton: ${model.robot}`;
  }

  following(on: boolean): void {
    element('follow').classList.toggle('on', on);
  }

  toggleHelp(): void {
    const help = element<HTMLDialogElement>('help');
    if (help.open) return help.close();
    this.actions.letGo(); // release the stick while reading
    help.showModal();
    help.scrollTop = 0; // not at the focused element
  }

  /** Covers the page with a text; '' removes the cover. */
  cover(content: string): void {
    element('cover').classList.toggle('hidden', content === '');
    if (content !== '') text('cover-text', content);
  }

  /** For programs that inspect the page. */
  activity(what: Activity): void {
    document.body.dataset.state = what;
  }

  disconnected(): void {
    this.activity('waiting');
    this.role('lost', 'no connection');
    this.cover('The program does not answer. The page reconnects when it runs again.');
  }

  /** Connected, but no data arrives; cleared by the next state. */
  noSignal(): void {
    this.activity('waiting');
    this.role('lost', 'no signal');
    note('hint', 'No signal from the program: the view is outdated, and the stick counts as centred.');
  }

  pad(description: string): void {
    text('pad', description);
  }

  show(state: State, now: number): void {
    const drives = state.role === 'driver';
    this.role(
      drives ? 'driver' : 'watcher',
      drives ? 'you drive' : state.taken ? 'watching' : 'nobody drives',
    );
    element('take').hidden = !drives && state.taken;
    text('take', drives ? 'Release the stick' : 'Take the stick');
    document.body.classList.toggle('watching', !drives);
    // A driver sees its own stick at once; the command in force arrives a moment later.
    this.choose(drives ? this.stick.guide : state.guide);
    this.bars.forEach((bar, i) => deflect(bar, state.axes[i] ?? 0));
    const lift = drives ? this.stick.lift : state.lift;
    this.sliders.forEach((slider, i) => {
      if (document.activeElement !== slider) slider.value = String(lift[i] ?? 0);
    });

    const goal = state.goal;
    const fallen = state.state === 'fallen';
    const part = goal && inWords(goal.swing ? `${goal.swing}_foot` : goal.guided);
    const segment = goal && (goal.kind === 'arms' ? 'arms: driven from outside' : `${goal.kind}: ${part}`);
    text('segment', fallen ? 'fallen' : (segment ?? 'at rest'));
    text('phase', fallen ? '' : support(state.contact));
    text('time', `${state.t.toFixed(1)} s`);
    const done = goal && state.segment.duration ? (state.segment.time ?? 0) / state.segment.duration : 0;
    element('progress').style.width = `${Math.round(100 * Math.min(1, done))}%`;
    text('com', metres(state.com));
    text('zmp', metres(state.zmp));

    const hint = fallen ? 'The run is over. The program ends when the page is closed.' : state.device.hint;
    note('hint', !fallen && state.device.armed ? '' : hint);
    note('message', state.message);
    element('damp').hidden = !state.damps;
    element('damp-key').hidden = !state.damps;
    element('message').classList.toggle('fallen', fallen);
    this.wayBack(state, drives ? this.stick.recall() : 'none');
    this.limited(state, now);
    this.refused(state, now);
  }

  private wayBack(state: State, asked: Recall): void {
    const held = asked === 'none' ? state.recall : asked;
    for (const button of document.querySelectorAll<HTMLElement>('[data-way]'))
      button.classList.toggle('on', button.dataset.way === held);
    text('left', state.history > 0 ? String(state.history) : '');
    note('recall', recallText(state));
    note('stuck', stuckText(state.stuck));
  }

  /** Shown a little longer than the motion, but not during a later unlimited one. */
  private limited({ limit, goal }: State, now: number): void {
    if (limit) {
      this.limitUntil = now + freshFor;
      text('limit', limitText(limit));
    } else if (goal) {
      this.limitUntil = now;
    }
    element('limit').hidden = now >= this.limitUntil;
  }

  private refused(state: State, now: number): void {
    const entries = this.refusals.entries;
    const line = ({ text: what, count }: (typeof entries)[number]): string =>
      count > 1 ? `${what} ×${count}` : what;
    if (this.refusals.add(state.refusal, state.refusals)) {
      this.refusedAt = now;
      this.limitUntil = now;
      note('refusal', entries[0]!.text);
      const older = entries.slice(1).map((entry) => {
        const item = document.createElement('li');
        item.textContent = line(entry);
        return item;
      });
      element('history').replaceChildren(...older);
    }
    element('refusal').classList.toggle('old', now - this.refusedAt > freshFor);
  }

  private choose(part: Part): void {
    for (const [name, button] of this.buttons) {
      button.classList.toggle('on', name === part);
      button.setAttribute('aria-pressed', String(name === part));
    }
  }

  private role(kind: string, words: string): void {
    element('role').dataset.role = kind;
    text('role', words);
  }

  private onClick(id: string, action: () => void): void {
    const button = element<HTMLButtonElement>(id);
    button.onclick = () => {
      action();
      button.blur();
    };
  }

  /** Recall button: active only while pressed with the pointer on it. */
  private whilePressed(button: HTMLButtonElement): void {
    const way = button.dataset.way as Recall;
    const { stick } = this;
    let pointer: number | null = null;
    button.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      pointer = event.pointerId;
      if (button.hasPointerCapture(pointer)) button.releasePointerCapture(pointer); // so that a finger can leave
      stick.hold(way);
      this.actions.moved();
    });
    const end = (event: PointerEvent): void => {
      if (event.pointerId !== pointer) return;
      pointer = null;
      stick.buttons.delete(way);
      button.blur(); // Space is a key of the stick
      this.actions.moved();
    };
    button.addEventListener('pointerleave', end);
    addEventListener('pointerup', end); // anywhere on the page
    addEventListener('pointercancel', end);
    button.addEventListener('contextmenu', (event) => event.preventDefault()); // from a long touch
  }

  private addAxis(name: string, keys: string): HTMLElement {
    const row = element('axes').appendChild(document.createElement('div'));
    row.className = 'axis';
    row.appendChild(document.createElement('span')).textContent = name;
    const bar = row.appendChild(document.createElement('b')).appendChild(document.createElement('i'));
    const caps = row.appendChild(document.createElement('span'));
    for (const key of keys.split(' ')) caps.appendChild(document.createElement('kbd')).textContent = key;
    return bar;
  }
}

function deflect(bar: HTMLElement, value: number): void {
  bar.style.left = `${50 + 50 * Math.min(0, value)}%`;
  bar.style.width = `${50 * Math.abs(value)}%`;
}

function support([left, right]: [boolean, boolean]): string {
  if (left && right) return 'double support';
  if (left || right) return `single support: ${left ? 'left' : 'right'} foot`;
  return 'in the air';
}
