/** What is asked for in place of the stick, in words. */
import type { State } from './protocol';

const stuckAfter = 3; // commands refused in a row

/** What goes on while a button is held; '' when there is nothing to say. */
export function recallText({ recall, history, goal }: Pick<State, 'recall' | 'history' | 'goal'>): string {
  if (recall === 'stop') return goal ? 'stopping' : 'stopped: nothing begins while this is held';
  if (recall === 'home') return 'home: to the stance that it began in';
  if (recall === 'none' || (history === 0 && !goal)) return ''; // the refusal says that nothing is left
  return `retracing: back the way it came${history > 0 ? `, ${history} more` : ''}`;
}

/** What leads out when nothing goes; '' while something does. */
export function stuckText(refusedInARow: number, history: number): string {
  if (refusedInARow < stuckAfter) return '';
  const ways = history > 0 ? 'Retrace (Backspace) or Home (H) leads out.' : 'Home (H) leads out.';
  return `Nothing goes from here. ${ways}`;
}
