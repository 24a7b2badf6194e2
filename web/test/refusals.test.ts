import { expect, test } from 'vitest';
import { inWords, type Refusal } from '../src/protocol';
import table from '../src/reasons.json';
import { limitText, RefusalLog, refusalText } from '../src/refusals';

const refusal = (reason: string, change: Partial<Refusal> = {}): Refusal => ({
  reason,
  part: 'left_foot',
  value: 0.12,
  limit: 0.11,
  where: '',
  cause: null,
  ...change,
});

test('names the part, the reason and the numbers', () => {
  const text = (...of: Parameters<typeof refusal>): string => refusalText(refusal(...of));
  expect(text('foot_region')).toBe(
    'left foot: the foothold would lie outside its reach (0.12 m, at most 0.11 m)',
  );
  expect(text('sole_gap', { value: 0.0042, limit: 0.006 })).toBe(
    'left foot: the soles would come too close to each other (4.2 mm, at least 6 mm)',
  );
  expect(text('trunk_inclination', { part: 'trunk', value: 0.4, limit: 0.3 })).toBe(
    'trunk: the trunk would tilt too far (22.9°, at most 17.2°)',
  );
  expect(text('joint_torque', { part: 'trunk', value: 1.2, limit: 0.9, where: 'left_knee' })).toBe(
    'trunk: a motor would need too much torque, left knee (120 %, at most 90 %)',
  );
  expect(text('no_progress', { value: 0.004, limit: 0.006, cause: 'sole_gap' })).toBe(
    'left foot: no foothold brings the robot nearer to the goal: ' +
      'the soles would come too close to each other (4 mm, at least 6 mm)',
  );
  expect(text('no_progress')).toBe('left foot: no foothold brings the robot nearer to the goal');
  expect(text('zmp', { value: null })).not.toContain('(');
  expect(text('no_history', { part: 'trunk', value: 0, limit: 0 })).toBe('nothing left to retrace');
});

test('a limit is the reason why a motion is only a part of the way', () => {
  expect(limitText(refusal('foot_region'))).toBe(
    'only part of the way: left foot: the foothold would lie outside its reach (0.12 m, at most 0.11 m)',
  );
});

test('has words, a unit and a bound for every reason', () => {
  expect(Object.keys(table).length).toBeGreaterThan(10);
  for (const [name, { unit, bound }] of Object.entries(table)) {
    const text = refusalText(refusal(name));
    expect(text, name).not.toContain(`: ${inWords(name)} (`);
    expect(/\(.*at (most|least).*\)$/.test(text), name).toBe(unit !== 'none');
    if (bound.startsWith('at')) expect(text, name).toContain(`, ${bound} `);
  }
});

test('a value at its limit is held to the bound of its reason', () => {
  const both = { value: 3, limit: 3 };
  expect(refusalText(refusal('joint_speed', both))).toContain('(3 rad/s, at most 3 rad/s)');
  expect(refusalText(refusal('sole_gap', both))).toContain('(3 m, at least 3 m)');
  expect(refusalText(refusal('foot_region', { value: 2, limit: 3 }))).toContain('(2 m, at least 3 m)');
});

test('shows a reason that it does not know as it is', () => {
  expect(refusalText(refusal('new_reason', { part: 'tail' }))).toBe('tail: new reason (0.12, at most 0.11)');
});

test('the log counts repetitions, keeps the last few, and starts anew with another run', () => {
  const log = new RefusalLog(2);
  expect(log.add(null, 0)).toBe(false);
  expect(log.add(refusal('zmp'), 1)).toBe(true);
  expect(log.add(refusal('zmp'), 1)).toBe(false);
  expect(log.add(refusal('zmp'), 4)).toBe(true);
  expect(log.entries.map(({ count }) => count)).toEqual([4]);
  log.add(refusal('ground'), 5);
  log.add(refusal('friction'), 6);
  expect(log.entries.map(({ key }) => key.split(' ')[0])).toEqual(['friction', 'ground']);
  expect(log.add(refusal('friction'), 1)).toBe(true);
});
