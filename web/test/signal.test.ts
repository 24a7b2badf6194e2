import { expect, test } from 'vitest';
import { Signal, silence } from '../src/signal';

test('is lost when nothing has come for a while, and back with the next state', () => {
  const signal = new Signal();
  signal.heard(1000);
  expect(signal.lost(1000 + silence)).toBe(false);
  expect(signal.lost(1001 + silence)).toBe(true);
  signal.heard(5000);
  expect(signal.lost(5001)).toBe(false);
});

test('is not lost before the first state, nor when the connection is closed', () => {
  const signal = new Signal();
  expect(signal.lost(1e9)).toBe(false);
  signal.heard(0);
  signal.closed();
  expect(signal.lost(1e9)).toBe(false);
});

test('a state that came after the picture was begun does not count as lost', () => {
  const signal = new Signal();
  signal.heard(1010);
  expect(signal.lost(1000)).toBe(false);
});
