import { expect, test } from 'vitest';
import type { Goal, State } from '../src/protocol';
import { recallText, stuckText } from '../src/recall';

const goal = {} as Goal;
const words = (recall: State['recall'], history: number, of: Goal | null): string =>
  recallText({ recall, history, goal: of });

test('what is asked for in place of the stick is named', () => {
  expect(words('none', 5, goal)).toBe('');
  expect(words('retrace', 5, goal)).toBe('retracing: back the way it came, 5 more');
  expect(words('retrace', 0, goal)).toBe('retracing: back the way it came'); // the first motion of all
  expect(words('retrace', 0, null)).toBe('');
  expect(words('home', 0, null)).toMatch(/^home: /);
  expect(words('stop', 5, goal)).toBe('stopping');
  expect(words('stop', 5, null)).toMatch(/^stopped: /);
});

test('after three refusals in a row it is said what leads out', () => {
  expect(stuckText(0, 5)).toBe('');
  expect(stuckText(2, 5)).toBe('');
  expect(stuckText(3, 5)).toBe('Nothing goes from here. Retrace (Backspace) or Home (H) leads out.');
  expect(stuckText(9, 0)).toBe('Nothing goes from here. Home (H) leads out.');
});
