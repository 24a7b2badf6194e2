/** A refusal in plain words: which part, why, and by how much. */
import { inWords, type Refusal, type Value } from './protocol';
import table from './reasons.json';

type Unit = 'length' | 'angle' | 'speed' | 'acceleration' | 'share' | 'number' | 'none';
type Bound = 'at least' | 'at most' | 'range' | 'none';

/** Copy of the program's table in baton/motion/reason.hpp; a test of the program compares them. */
const reasons = table as Record<string, { unit: Unit; bound: Bound; text: string }>;

const rounded = (value: number, digits: number): string => String(Number(value.toFixed(digits)));

function amount(value: number, unit: Unit, scale: number): string {
  switch (unit) {
    case 'length':
      return scale < 0.1 ? `${rounded(value * 1000, 1)} mm` : `${rounded(value, 3)} m`;
    case 'angle':
      return `${rounded((value * 180) / Math.PI, 1)}°`;
    case 'speed':
      return `${rounded(value, 2)} rad/s`;
    case 'acceleration':
      return `${rounded(value, 0)} rad/s²`;
    case 'share':
      return `${rounded(value * 100, 0)} %`;
    default:
      return rounded(value, 3);
  }
}

function numbers(value: Value, limit: Value, unit: Unit, bound: Bound): string {
  if (unit === 'none' || value === null || limit === null || (value === 0 && limit === 0)) return '';
  const scale = Math.max(Math.abs(value), Math.abs(limit));
  const side = bound === 'range' ? (value > limit ? 'at most' : 'at least') : bound;
  return ` (${amount(value, unit, scale)}, ${side} ${amount(limit, unit, scale)})`;
}

/** "left foot: the foothold would lie outside its reach (0.12 m, at most 0.11 m)" */
export function refusalText({ reason, part, value, limit, where, cause }: Refusal): string {
  const known = reasons[reason] ?? { text: inWords(reason), unit: 'number', bound: 'range' };
  if (reason === 'no_history') return known.text; // independent of the part
  const why = (cause && reasons[cause]) || known; // the reason that the numbers belong to
  let text = why === known ? known.text : `${known.text}: ${why.text}`;
  if (where !== '' && !part.includes(where)) text += `, ${inWords(where)}`;
  return `${inWords(part)}: ${text}${numbers(value, limit, why.unit, why.bound)}`;
}

/** Why a motion does only part of what was asked. */
export const limitText = (limit: Refusal): string => `only part of the way: ${refusalText(limit)}`;

/** The last few refusals, newest first; repetitions are counted. */
export class RefusalLog {
  readonly entries: { text: string; count: number; key: string }[] = [];
  private seen = 0;

  constructor(private readonly length = 5) {}

  /** Adds the newest refusal, given the total since the start; true if something changed. */
  add(refusal: Refusal | null, total: number): boolean {
    if (total < this.seen) this.seen = 0; // a new run
    if (refusal === null || total === this.seen) return false;
    const count = total - this.seen;
    this.seen = total;
    const key = `${refusal.reason} ${refusal.part} ${refusal.where} ${refusal.cause ?? ''}`;
    const newest = this.entries[0];
    if (newest?.key === key) {
      newest.text = refusalText(refusal);
      newest.count += count;
    } else {
      this.entries.unshift({ text: refusalText(refusal), count, key });
      this.entries.length = Math.min(this.entries.length, this.length);
    }
    return true;
  }
}
