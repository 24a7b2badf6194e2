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

  /** Centres all that could be held: the page lost its keys, or the operator wants to stop. */
  letGo(): void {
    this.keyboard.releaseAll();
    this.buttons.clear();
    this.lift = [0, 0];
  }

  /** Keys that are no axes: 1…5 choose, L lifts the guided foot or lowers it, Space lets go of all else. */
  press(code: string): boolean {
    const digit = /^(?:Digit|Numpad)([1-5])$/.exec(code);
    if (digit) {
      this.guide = parts[Number(digit[1]) - 1]!;
    } else if (code === 'KeyL') {
      if (!isFoot(this.guide)) return true;
      const foot = this.guide === 'left_foot' ? 0 : 1;
      this.lift[foot] = this.lift[foot] > 0 ? 0 : 1;
    } else {
      if (code === 'Space') this.letGo();
      return this.keyboard.press(code);
    }
    return true;
  }

  /** What keys and buttons of the page ask for in place of the stick. */
  recall(): Recall {
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
    const axes = this.keyboard.axes();
    const recall = this.recall();
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
