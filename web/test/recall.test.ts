import { expect, test } from 'vitest';
import type { State, Stuck } from '../src/protocol';
import { recallText, stuckText } from '../src/recall';

const words = (recall: State['recall'], state: State['state'], history = 0): string =>
  recallText({ recall, state, history });

test('what goes on in place of the stick is named', () => {
  expect(words('none', 'moving', 5)).toBe('');
  expect(words('retrace', 'retracing', 5)).toBe('retracing: back the way it came, 5 more');
  expect(words('retrace', 'retracing')).toBe('retracing: back the way it came'); // the first motion of all
  expect(words('home', 'retracing')).toMatch(/^home: /);
  expect(words('stop', 'stopping', 5)).toBe('stopping');
  expect(words('stop', 'rest', 5)).toMatch(/^stopped: /);
});

test('a way back that does not go on is not told of: refused, over, or not begun', () => {
  for (const recall of ['retrace', 'home'] as const)
    for (const state of ['rest', 'moving', 'stopping', 'fallen'] as const)
      expect(words(recall, state, 2)).toBe('');
  expect(words('none', 'retracing', 2)).toBe(''); // let go of: it ends what it began
});

test('of a part that is refused again and again it is said what leads out', () => {
  const stuck = (change: Partial<Stuck> = {}): Stuck => ({
    part: 'left_foot',
    times: 3,
    retrace: true,
    home: true,
    ...change,
  });
  const said = 'The left foot was refused three times in a row. Another part may move';
  expect(stuckText(null)).toBe('');
  expect(stuckText(stuck())).toBe(`${said}, and Retrace (Backspace) or Home (H) leads out.`);
  expect(stuckText(stuck({ retrace: false }))).toBe(`${said}, and Home (H) leads out.`);
  expect(stuckText(stuck({ home: false }))).toBe(`${said}, and Retrace (Backspace) leads out.`);
  expect(stuckText(stuck({ retrace: false, home: false }))).toBe(`${said}.`);
  expect(stuckText(stuck({ times: 4 }))).toContain('4 times');
});
