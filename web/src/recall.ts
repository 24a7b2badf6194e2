/** Texts about retrace, home and stop. */
import { inWords, type State, type Stuck } from './protocol';

/** Text while a recall button is held; '' if none applies. */
export function recallText({ recall, state, history }: Pick<State, 'recall' | 'state' | 'history'>): string {
  if (recall === 'stop' && state === 'stopping') return 'stopping';
  if (recall === 'stop' && state === 'rest') return 'stopped: no motion starts while this is held';
  if (state !== 'retracing') return ''; // refused, or waiting for the previous motion to end
  if (recall === 'home') return 'home: back to the initial stance';
  if (recall !== 'retrace') return '';
  return `retracing: back the way it came${history > 0 ? `, ${history} more` : ''}`;
}

/** Advice for a part that is refused repeatedly. */
export function stuckText(stuck: Stuck | null): string {
  if (!stuck) return '';
  const times = stuck.times === 3 ? 'three' : String(stuck.times);
  const ways = [stuck.retrace ? 'Retrace (Backspace)' : '', stuck.home ? 'Home (H)' : ''].filter(Boolean);
  const advice = ways.length > 0 ? `, and ${ways.join(' or ')} leads out` : '';
  return `The ${inWords(stuck.part)} was refused ${times} times in a row. Another part may move${advice}.`;
}
