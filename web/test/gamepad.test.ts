import { describe, expect, test } from 'vitest';
import { deadZone, shape, type Pad } from '../src/gamepad';
import { Stick } from '../src/stick';

interface Touch {
  axes?: number[];
  buttons?: Record<number, number>;
  index?: number;
  mapping?: string;
}

function pad({ axes = [0, 0, 0, 0], buttons = {}, index = 0, mapping = 'standard' }: Touch = {}): Pad {
  const values = Array.from({ length: 17 }, (_, i) => buttons[i] ?? 0);
  return {
    index,
    id: 'pad',
    mapping,
    connected: true,
    axes,
    buttons: values.map((value) => ({ value, pressed: value > 0.5 })),
  };
}
const LB = { 4: 1 };

function armed(): Stick {
  const stick = new Stick();
  stick.command(pad());
  return stick;
}

describe('dead zone and curve', () => {
  test('nothing inside the dead zone, everything at the end', () => {
    for (const x of [0, deadZone, -deadZone, NaN]) expect(Math.abs(shape(x))).toBe(0);
    expect(shape(1)).toBeCloseTo(1);
    expect(shape(-1)).toBeCloseTo(-1);
    expect(shape(1.5)).toBeCloseTo(1);
  });

  test('odd, rising, without a jump, and fine in the middle', () => {
    for (let x = 0; x < 1; x += 0.01) {
      expect(shape(-x)).toBeCloseTo(-shape(x));
      const rise = shape(x + 0.01) - shape(x);
      expect(rise).toBeGreaterThanOrEqual(0);
      expect(rise).toBeLessThan(0.03);
    }
    expect(shape(0.5)).toBeLessThan(0.4);
  });
});

describe('the pad', () => {
  test('moves the six axes', () => {
    const stick = armed();
    expect(stick.command(pad({ axes: [-1, -1, 0, 0], buttons: LB })).axes).toEqual([1, 1, 0, 0, 0, 0]);
    expect(stick.command(pad({ axes: [0, 0, -1, -1], buttons: LB })).axes).toEqual([0, 0, 1, 0, 0, 1]);
    expect(stick.command(pad({ buttons: { ...LB, 12: 1, 15: 1 } })).axes).toEqual([0, 0, 0, 1, 1, 0]);
    expect(stick.command(pad({ buttons: { ...LB, 6: 1, 7: 1 } })).lift).toEqual([1, 1]);
  });

  test('counts only while its bumper is held, unless that is switched off', () => {
    const stick = armed();
    expect(stick.command(pad({ axes: [0, -1, 0, 0] })).deadman).toBe(false);
    expect(stick.command(pad({ axes: [0, -1, 0, 0], buttons: LB })).deadman).toBe(true);
    stick.gamepad.needsHold = false;
    expect(stick.command(pad({ axes: [0, -1, 0, 0] })).deadman).toBe(true);
  });

  test('counts once it was centred since it appeared', () => {
    const stick = new Stick();
    const push = { axes: [0, -1, 0, 0], buttons: LB };
    expect(stick.command(pad(push)).axes).toEqual([0, 0, 0, 0, 0, 0]);
    stick.command(pad());
    expect(stick.command(pad(push)).axes[0]).toBe(1);
    stick.command(null); // unplugged, and back
    expect(stick.command(pad(push)).axes[0]).toBe(0);
    expect(stick.command(pad({ ...push, index: 1 })).axes[0]).toBe(0);
  });

  test('goes back while Back or Start is held, stops while a stick is pressed in, and the bumper', () => {
    const stick = armed();
    const recall = (...buttons: number[]): string => {
      stick.rests();
      return stick.command(pad({ buttons: { ...LB, ...Object.fromEntries(buttons.map((b) => [b, 1])) } }))
        .recall;
    };
    expect(recall(8)).toBe('retrace');
    expect(recall(9)).toBe('home');
    expect(recall(8, 9)).toBe('retrace');
    expect(recall(8, 10)).toBe('stop');
    expect(recall(11)).toBe('stop');
    expect(recall()).toBe('none');
    expect(stick.command(pad({ buttons: { 8: 1 } })).deadman).toBe(false);
    stick.press('KeyH');
    expect(stick.command(pad({ buttons: { 8: 1 } }))).toMatchObject({ recall: 'home', deadman: true });
    stick.press('Space');
    expect(recall(8)).toBe('stop'); // whatever the pad asks for
  });

  test('stops until the robot rests, with nothing else of it', () => {
    const stick = armed();
    const push = { axes: [0, -1, 0, 0], buttons: LB };
    stick.command(pad({ ...push, buttons: { ...LB, 10: 1, 6: 1 } }));
    const still = { axes: [0, 0, 0, 0, 0, 0], lift: [0, 0], recall: 'stop', deadman: true };
    expect(stick.command(pad(push))).toMatchObject(still);
    expect(stick.command(null)).toMatchObject(still);
    stick.rests();
    expect(stick.command(pad(push)).recall).toBe('none');
  });

  test('counts once Back and Start were let go, too', () => {
    const stick = new Stick();
    expect(stick.command(pad({ buttons: { ...LB, 8: 1 } })).recall).toBe('none');
    stick.command(pad());
    expect(stick.command(pad({ buttons: { ...LB, 8: 1 } })).recall).toBe('retrace');
  });

  test('chooses parts, once for each press', () => {
    const stick = armed();
    const after = (buttons: Record<number, number>): string => stick.command(pad({ buttons })).guide;
    expect(after({ 2: 1 })).toBe('left_foot');
    stick.guide = 'trunk';
    expect(after({ 2: 1 })).toBe('trunk');
    after({});
    expect(after({ 1: 1 })).toBe('right_foot');
    expect(after({ 1: 1, 3: 1 })).toBe('right_foot'); // two at once choose nothing
    after({});
    expect(after({ 3: 1 })).toBe('left_hand');
    expect(after({ 5: 1 })).toBe('right_hand');
    expect(after({ 0: 1 })).toBe('trunk');
  });

  test('of an unknown layout is not used', () => {
    const stick = armed();
    expect(stick.command(pad({ axes: [0, -1, 0, 0], buttons: LB, mapping: '' })).axes[0]).toBe(0);
  });

  test('that drifts without its bumper does not take the keys away', () => {
    const stick = armed();
    stick.press('KeyA');
    const command = stick.command(pad({ axes: [0, -1, 0, 0] }));
    expect(command.axes).toEqual([0, 1, 0, 0, 0, 0]);
    expect(command.deadman).toBe(true);
  });
});
