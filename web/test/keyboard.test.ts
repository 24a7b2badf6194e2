import { expect, test } from 'vitest';
import { Stick } from '../src/stick';

const axesAfter = (...codes: string[]): number[] => {
  const stick = new Stick();
  for (const code of codes) expect(stick.press(code)).toBe(true);
  return stick.command(null).axes;
};

test('each axis has a key for either direction, positive by the right hand', () => {
  const pairs = [
    'KeyW KeyS',
    'KeyA KeyD',
    'KeyR KeyF',
    'ArrowRight ArrowLeft',
    'ArrowUp ArrowDown',
    'KeyQ KeyE',
  ];
  pairs.forEach((pair, axis) => {
    const [plus, minus] = pair.split(' ') as [string, string];
    const unit = (sign: number): number[] => [0, 0, 0, 0, 0, 0].map((_, i) => (i === axis ? sign : 0));
    expect(axesAfter(plus)).toEqual(unit(1));
    expect(axesAfter(minus)).toEqual(unit(-1));
    expect(axesAfter(plus, minus)).toEqual(unit(0));
  });
});

test('Shift halves, keys add up over axes and end when released', () => {
  const { keyboard } = new Stick();
  keyboard.press('KeyW');
  keyboard.press('KeyQ');
  keyboard.shift(true);
  expect(keyboard.axes()).toEqual([0.5, 0, 0, 0, 0, 0.5]);
  keyboard.shift(false);
  keyboard.release('KeyW');
  expect(keyboard.axes()).toEqual([0, 0, 0, 0, 0, 1]);
});

test('1 to 5 choose the part', () => {
  const stick = new Stick();
  const chosen = ['Digit1', 'Digit2', 'Digit3', 'Digit4', 'Numpad5'].map((code) => {
    stick.press(code);
    return stick.command(null).guide;
  });
  expect(chosen).toEqual(['left_foot', 'right_foot', 'left_hand', 'right_hand', 'trunk']);
});

test('L lifts the guided foot and lowers it, and no hand', () => {
  const stick = new Stick();
  const lift = (): number[] => stick.command(null).lift;
  stick.press('KeyL');
  expect(lift()).toEqual([0, 0]);
  stick.press('Digit2');
  stick.press('KeyL');
  expect(lift()).toEqual([0, 1]);
  stick.press('KeyL');
  expect(lift()).toEqual([0, 0]);
});

test('Space centres everything, keeps the part, and stops until it is let go of and the robot rests', () => {
  const stick = new Stick();
  for (const code of ['Digit1', 'KeyL', 'KeyW', 'Space']) stick.press(code);
  const stop = {
    guide: 'left_foot',
    axes: [0, 0, 0, 0, 0, 0],
    lift: [0, 0],
    recall: 'stop',
    deadman: true,
  };
  expect(stick.command(null)).toEqual(stop);
  stick.rests();
  expect(stick.command(null)).toEqual(stop); // it is held
  stick.keyboard.release('Space');
  expect(stick.command(null)).toEqual(stop); // the robot moves yet
  stick.rests();
  expect(stick.command(null)).toEqual({ ...stop, recall: 'none' }); // though W is still down
});

test('a stop lasts until the robot rests, whoever held it and whatever lets go', () => {
  const ends: ((stick: Stick) => void)[] = [
    (stick) => stick.keyboard.release('Space'),
    (stick) => stick.buttons.delete('stop'),
    (stick) => stick.letGo(), // the page was left
  ];
  for (const begin of [(stick: Stick) => stick.press('Space'), (stick: Stick) => stick.hold('stop')]) {
    const stick = new Stick();
    stick.press('KeyW');
    stick.lift = [0, 1];
    begin(stick);
    for (const end of ends) end(stick);
    stick.press('KeyA'); // another key, meanwhile
    expect(stick.command(null)).toMatchObject({ axes: [0, 0, 0, 0, 0, 0], lift: [0, 0], recall: 'stop' });
    stick.rests();
    expect(stick.command(null)).toMatchObject({ axes: [0, 1, 0, 0, 0, 0], lift: [0, 0], recall: 'none' });
  }
});

test('Backspace retraces, H or Home goes home, and Space stops, while held', () => {
  for (const [code, way] of [
    ['Backspace', 'retrace'],
    ['KeyH', 'home'],
    ['Home', 'home'],
    ['Space', 'stop'],
  ] as const) {
    const stick = new Stick();
    expect(stick.press(code)).toBe(true);
    expect(stick.command(null).recall).toBe(way);
    expect(stick.command(null).axes).toEqual([0, 0, 0, 0, 0, 0]);
    stick.keyboard.release(code);
    stick.rests();
    expect(stick.command(null).recall).toBe('none');
  }
});

test('stop wins over retrace, and retrace over home, be they keys or buttons', () => {
  const stick = new Stick();
  stick.buttons.add('home');
  expect(stick.command(null).recall).toBe('home');
  stick.press('Backspace');
  expect(stick.command(null).recall).toBe('retrace');
  stick.keyboard.release('Backspace');
  expect(stick.command(null).recall).toBe('home');
  stick.hold('stop');
  expect(stick.command(null).recall).toBe('stop');
  stick.buttons.delete('stop');
  stick.rests();
  expect(stick.command(null).recall).toBe('none'); // stop let go of the button, too
});

test('letting go ends a way back, of keys and of buttons', () => {
  const stick = new Stick();
  stick.press('KeyH');
  stick.buttons.add('retrace');
  stick.letGo();
  expect(stick.command(null).recall).toBe('none');
});

test('on a way back, a foot that stands is not lifted again afterwards', () => {
  const stick = new Stick();
  stick.lift = [1, 0.5];
  stick.goingBack([false, true]);
  expect(stick.command(null).lift).toEqual([1, 0]);
  stick.goingBack([true, true]);
  expect(stick.command(null).lift).toEqual([0, 0]);
});

test('other keys are left to the browser', () => {
  expect(new Stick().press('F5')).toBe(false);
});
