/** A gamepad with the browser's "standard" mapping as a stick. Knows nothing of the browser. */
import { oneOf, type Part, type Recall } from './protocol';

/** The used part of the browser's Gamepad. */
export interface Pad {
  index: number;
  id: string;
  mapping: string;
  connected: boolean;
  axes: readonly number[];
  buttons: readonly { pressed: boolean; value: number }[];
}

export interface PadInput {
  axes: number[];
  lift: [number, number];
  recall: Recall;
  deadman: boolean;
  choose: Part | null; // part whose button was pressed since the last reading
}

/** Whether any control except the bumper is deflected or pressed. */
export const touched = ({ axes, lift, recall }: PadInput): boolean =>
  recall !== 'none' || [...axes, ...lift].some((value) => value !== 0);

export const deadZone = 0.08;
const curve = 0.5; // c: 0 linear … 1 cubic

/**
 * Dead zone d, then a curve with fine control near the centre, as in docs/input.md: (1−c)u + cu³ with u = (x−d)/(1−d).
 */
export function shape(value: number, c = curve): number {
  if (!Number.isFinite(value)) return 0;
  const size = Math.min(1, Math.abs(value));
  if (size <= deadZone) return 0;
  const u = (size - deadZone) / (1 - deadZone);
  return Math.sign(value) * ((1 - c) * u + c * u ** 3);
}

enum Button {
  A,
  B,
  X,
  Y,
  LB,
  RB,
  LT,
  RT,
  Back,
  Start,
  LS,
  RS,
  Up,
  Down,
  Left,
  Right,
}

export class Gamepad {
  /** The pad counts only while the left bumper is held. */
  needsHold = true;
  private index = -1;
  private armed = false;
  private chooser: Part | null = null;

  /** Axes and triggers of the pad, or null without one; a new pad counts once it has been centred. */
  read(pad: Pad | null): PadInput | null {
    if (pad === null || !pad.connected || pad.mapping !== 'standard') {
      this.index = -1;
      return null;
    }
    if (pad.index !== this.index) {
      this.index = pad.index;
      this.armed = false;
      this.chooser = null;
    }
    const axis = (i: number): number => shape(pad.axes[i] ?? 0);
    const pressed = (b: Button): boolean => pad.buttons[b]?.pressed ?? false;
    const trigger = (b: Button): number => Math.abs(shape(pad.buttons[b]?.value ?? 0, 0));
    const between = (minus: Button, plus: Button): number => Number(pressed(plus)) - Number(pressed(minus));

    const input: PadInput = {
      axes: [
        -axis(1), // x: left stick up
        -axis(0), // y: left stick left
        -axis(3), // z: right stick up
        between(Button.Left, Button.Right), // roll
        between(Button.Down, Button.Up), // pitch
        -axis(2), // yaw: right stick left
      ].map((value) => value + 0), // no −0
      lift: [trigger(Button.LT), trigger(Button.RT)],
      recall: oneOf([
        pressed(Button.LS) || pressed(Button.RS) ? 'stop' : 'none',
        pressed(Button.Back) ? 'retrace' : 'none',
        pressed(Button.Start) ? 'home' : 'none',
      ]),
      deadman: !this.needsHold || pressed(Button.LB),
      choose: this.newChoice(pressed),
    };
    if (!touched(input)) this.armed = true;
    return this.armed
      ? input
      : { axes: [0, 0, 0, 0, 0, 0], lift: [0, 0], recall: 'none', deadman: false, choose: input.choose };
  }

  /** The selecting button that is pressed; two at once select nothing. */
  private newChoice(pressed: (button: Button) => boolean): Part | null {
    const choices: [Button, Part][] = [
      [Button.A, 'trunk'],
      [Button.X, 'left_foot'],
      [Button.B, 'right_foot'],
      [Button.Y, 'left_hand'],
      [Button.RB, 'right_hand'],
    ];
    const chosen = choices.filter(([button]) => pressed(button));
    const part = chosen.length === 1 ? chosen[0]![1] : null;
    const isNew = part !== this.chooser;
    this.chooser = part;
    return isNew ? part : null;
  }
}
