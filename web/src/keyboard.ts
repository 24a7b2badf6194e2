/** Keyboard as a stick: held keys deflect the axes fully, with Shift by half. Independent of the browser. */
import { oneOf, type Recall } from './protocol';

/** Key (position on an English keyboard) → axis and direction. */
const axisKeys: Record<string, [axis: number, sign: number]> = {
  KeyW: [0, 1],
  KeyS: [0, -1],
  KeyA: [1, 1],
  KeyD: [1, -1],
  KeyR: [2, 1],
  KeyF: [2, -1],
  ArrowRight: [3, 1], // roll: leans to the right
  ArrowLeft: [3, -1],
  ArrowUp: [4, 1], // pitch: leans forward
  ArrowDown: [4, -1],
  KeyQ: [5, 1], // yaw: turns to the left
  KeyE: [5, -1],
};

/** Key → recall while held. */
const recallKeys: Record<string, Recall> = {
  Backspace: 'retrace',
  KeyH: 'home',
  Home: 'home',
  Space: 'stop',
};

export class Keyboard {
  private readonly held = new Set<string>();
  private half = false;

  /** True if the key is one of the stick's. */
  press(code: string): boolean {
    if (!(code in axisKeys) && !(code in recallKeys)) return false;
    this.held.add(code);
    return true;
  }

  release(code: string): void {
    this.held.delete(code);
  }

  releaseAll(): void {
    this.held.clear();
    this.half = false;
  }

  shift(down: boolean): void {
    this.half = down;
  }

  axes(): number[] {
    const axes = [0, 0, 0, 0, 0, 0];
    for (const code of this.held) {
      const [axis, sign] = axisKeys[code] ?? [0, 0];
      axes[axis]! += sign * (this.half ? 0.5 : 1);
    }
    return axes;
  }

  recall(): Recall {
    return oneOf([...this.held].map((code) => recallKeys[code] ?? 'none'));
  }
}
