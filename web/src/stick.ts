/** All that the operator holds, as one command: the pad while it is touched, else keys and sliders. */
import { Gamepad, type Pad } from './gamepad';
import { Keyboard } from './keyboard';
import { isFoot, parts, type Command, type Part } from './protocol';

export class Stick {
  guide: Part = 'trunk';
  lift: [number, number] = [0, 0]; // of the sliders
  readonly keyboard = new Keyboard();
  readonly gamepad = new Gamepad();

  /** Centres all that could be held: the page lost its keys, or the operator wants to stop. */
  letGo(): void {
    this.keyboard.releaseAll();
    this.lift = [0, 0];
  }

  /** Keys that are no axes: 1…5 choose, L lifts the guided foot or lowers it, Space lets go. */
  press(code: string): boolean {
    const digit = /^(?:Digit|Numpad)([1-5])$/.exec(code);
    if (digit) {
      this.guide = parts[Number(digit[1]) - 1]!;
    } else if (code === 'KeyL') {
      if (!isFoot(this.guide)) return true;
      const foot = this.guide === 'left_foot' ? 0 : 1;
      this.lift[foot] = this.lift[foot] > 0 ? 0 : 1;
    } else if (code === 'Space') {
      this.letGo();
    } else {
      return this.keyboard.press(code);
    }
    return true;
  }

  /** The command of this moment. */
  command(pad: Pad | null): Command {
    const held = this.gamepad.read(pad);
    if (held?.choose) this.guide = held.choose;
    const touched = held !== null && [...held.axes, ...held.lift].some((value) => value !== 0);
    const axes = this.keyboard.axes();
    const idle = axes.every((value) => value === 0);
    if (touched && (held.deadman || idle)) {
      return { guide: this.guide, axes: held.axes, lift: held.lift, deadman: held.deadman };
    }
    return { guide: this.guide, axes, lift: [...this.lift], deadman: true };
  }
}

export function sameCommand(a: Command | null, b: Command): boolean {
  return a !== null && JSON.stringify(a) === JSON.stringify(b);
}
