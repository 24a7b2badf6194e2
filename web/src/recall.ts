/** What is asked for in place of the stick, in words. */
import { inWords, type State, type Stuck } from './protocol';

/** What goes on while a button is held; '' when there is nothing to say. */
export function recallText({ recall, state, history }: Pick<State, 'recall' | 'state' | 'history'>): string {
  if (recall === 'stop' && state === 'stopping') return 'stopping';
  if (recall === 'stop' && state === 'rest') return 'stopped: no motion starts while this is held';
  if (state !== 'retracing') return ''; // refused, or waiting for the motion before to end
  if (recall === 'home') return 'home: back to the initial stance';
  if (recall !== 'retrace') return '';
  return `retracing: back the way it came${history > 0 ? `, ${history} more` : ''}`;
}

/** What leads out for a part that is refused again and again. */
export function stuckText(stuck: Stuck | null): string {
  if (!stuck) return '';
  const times = stuck.times === 3 ? 'three' : String(stuck.times);
  const ways = [stuck.retrace ? 'Retrace (Backspace)' : '', stuck.home ? 'Home (H)' : ''].filter(Boolean);
  const advice = ways.length > 0 ? `, and ${ways.join(' or ')} leads out` : '';
  return `The ${inWords(stuck.part)} was refused ${times} times in a row. Another part may move${advice}.`;
}
