/** All that the operator holds, as one command: the pad while it is touched, else keys and sliders. */
import { Gamepad, touched, type Pad } from './gamepad';
import { Keyboard } from './keyboard';
import { isFoot, oneOf, parts, type Command, type Part, type Recall } from './protocol';

export class Stick {
  guide: Part = 'trunk';
  lift: [number, number] = [0, 0]; // of the sliders
  readonly buttons = new Set<Recall>(); // those of the page that are pressed
  readonly keyboard = new Keyboard();
  readonly gamepad = new Gamepad();
  private stopping = false; // until the robot rests, though nobody holds it any more

  /** Centres all that could be held: the page lost its keys, or the operator wants to stop. */
  letGo(): void {
    this.keyboard.releaseAll();
    this.buttons.clear();
    this.lift = [0, 0];
  }

  /** A button of the page is pressed. */
  hold(way: Recall): void {
    if (way === 'stop') this.stop();
    this.buttons.add(way);
  }

  /** The robot rests: a stop that nobody holds is over. */
  rests(): void {
    this.stopping = this.held() === 'stop';
  }

  /** Lets go of all else; lasts as long as it is held, and then until the robot rests. */
  private stop(): void {
    this.letGo();
    this.stopping = true;
  }

  /** Keys that are no axes: 1…5 choose, L lifts the guided foot or lowers it, Space stops. */
  press(code: string): boolean {
    const digit = /^(?:Digit|Numpad)([1-5])$/.exec(code);
    if (digit) {
      this.guide = parts[Number(digit[1]) - 1]!;
    } else if (code === 'KeyL') {
      if (!isFoot(this.guide)) return true;
      const foot = this.guide === 'left_foot' ? 0 : 1;
      this.lift[foot] = this.lift[foot] > 0 ? 0 : 1;
    } else {
      if (code === 'Space') this.stop();
      return this.keyboard.press(code);
    }
    return true;
  }

  /** What keys and buttons of the page ask for in place of the stick. */
  recall(): Recall {
    return this.stopping ? 'stop' : this.held();
  }

  private held(): Recall {
    return oneOf([this.keyboard.recall(), ...this.buttons]);
  }

  /** On a way back, a foot that stands is not lifted again afterwards. */
  goingBack(contact: readonly [boolean, boolean]): void {
    contact.forEach((stands, foot) => {
      if (stands) this.lift[foot] = 0;
    });
  }

  /** The command of this moment. */
  command(pad: Pad | null): Command {
    const held = this.gamepad.read(pad);
    if (held?.choose) this.guide = held.choose;
    if (held?.deadman && held.recall === 'stop') this.stop();
    const recall = this.recall();
    if (recall === 'stop') {
      return { guide: this.guide, axes: [0, 0, 0, 0, 0, 0], lift: [0, 0], recall, deadman: true };
    }
    const axes = this.keyboard.axes();
    const idle = recall === 'none' && axes.every((value) => value === 0);
    if (held !== null && touched(held) && (held.deadman || idle)) {
      const { axes, lift, deadman } = held;
      return { guide: this.guide, axes, lift, recall: oneOf([held.recall, recall]), deadman };
    }
    return { guide: this.guide, axes, lift: [...this.lift], recall, deadman: true };
  }
}

export function sameCommand(a: Command | null, b: Command): boolean {
  return a !== null && JSON.stringify(a) === JSON.stringify(b);
}
