/** Merges the operator's inputs into one command: the pad while touched, else keys and sliders. */
import { Gamepad, touched, type Pad } from './gamepad';
import { Keyboard } from './keyboard';
import { isFoot, oneOf, parts, type Command, type Part, type Recall } from './protocol';

export class Stick {
  guide: Part = 'trunk';
  lift: [number, number] = [0, 0]; // set by the sliders
  readonly buttons = new Set<Recall>(); // pressed buttons of the page
  readonly keyboard = new Keyboard();
  readonly gamepad = new Gamepad();
  private stopping = false; // lasts until the robot rests, even if released

  /** Centres everything: the page lost the keyboard, or the operator wants to stop. */
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

  /** The robot rests: a released stop is over. */
  rests(): void {
    this.stopping = this.held() === 'stop';
  }

  /** Releases everything else; lasts while held, and then until the robot rests. */
  private stop(): void {
    this.letGo();
    this.stopping = true;
  }

  /** Keys other than axes: 1…5 select a part, L lifts or lowers the guided foot, Space stops. */
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

  /** The recall that keys and buttons of the page ask for. */
  recall(): Recall {
    return this.stopping ? 'stop' : this.held();
  }

  private held(): Recall {
    return oneOf([this.keyboard.recall(), ...this.buttons]);
  }

  /** While going back, a foot that stands is set to be down, so that it is not lifted again afterwards. */
  goingBack(contact: readonly [boolean, boolean]): void {
    contact.forEach((stands, foot) => {
      if (stands) this.lift[foot] = 0;
    });
  }

  /** The current command. */
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
