/** A refusal in plain words: which part, why, and by how much. */
import { inWords, type Refusal, type Value } from './protocol';

type Unit = 'length' | 'angle' | 'speed' | 'acceleration' | 'share' | 'ratio' | 'none';

const reasons: Record<string, { text: string; unit: Unit; noPart?: true }> = {
  foot_region: { text: 'the foothold would lie outside its reach', unit: 'length' },
  foot_yaw: { text: 'the feet would be turned too far from each other', unit: 'angle' },
  sole_gap: { text: 'the soles would come too close to each other', unit: 'length' },
  ground: { text: 'there is no flat ground under the whole sole', unit: 'length' },
  com_height: { text: 'the body is at the end of its height range', unit: 'length' },
  trunk_inclination: { text: 'the trunk would tilt too far', unit: 'angle' },
  no_progress: { text: 'no foothold brings the robot nearer to the goal', unit: 'none' },
  no_landing: { text: 'the lifted foot could not be put down again from there', unit: 'none' },
  no_history: { text: 'nothing left to retrace', unit: 'none', noPart: true },
  inclined_sole: { text: 'it stands tilted, as on an edge: it cannot carry the robot alone', unit: 'angle' },
  zmp: { text: 'the robot would come too near to tipping over an edge of its soles', unit: 'length' },
  unreachable: { text: 'arms and legs cannot take up that posture', unit: 'ratio' },
  joint_limit: { text: 'a joint would come too near to the end of its range', unit: 'angle' },
  joint_speed: { text: 'a joint would have to turn too fast', unit: 'speed' },
  joint_acceleration: { text: 'a joint would have to jerk', unit: 'acceleration' },
  joint_torque: { text: 'a motor would have to be too strong', unit: 'share' },
  friction: { text: 'a foot would slip', unit: 'ratio' },
  contact_wrench: { text: 'the soles cannot give the force and the turn that it takes', unit: 'ratio' },
  self_collision: { text: 'two links would come too close to each other', unit: 'length' },
  obstacle: { text: 'a link would come too close to something in the way', unit: 'length' },
  swing_ground: { text: 'the foot would touch the ground on its way', unit: 'length' },
  not_finite: { text: 'the way there cannot be computed', unit: 'none' },
};

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

function numbers(value: Value, limit: Value, unit: Unit): string {
  if (unit === 'none' || value === null || limit === null || (value === 0 && limit === 0)) return '';
  const scale = Math.max(Math.abs(value), Math.abs(limit));
  const bound = value > limit ? 'at most' : 'at least';
  return ` (${amount(value, unit, scale)}, ${bound} ${amount(limit, unit, scale)})`;
}

/** "left foot: the foothold would lie outside its reach (0.12 m, at most 0.11 m)" */
export function refusalText({ reason, part, value, limit, where }: Refusal): string {
  const known = reasons[reason] ?? { text: inWords(reason), unit: 'ratio' as Unit };
  if (known.noPart) return known.text;
  let { text, unit } = known;
  const cause = reasons[where]; // what speaks against every foothold
  if (cause) {
    text += `: ${cause.text}`;
    unit = cause.unit;
  } else if (where !== '' && !part.includes(where)) {
    text += `, ${inWords(where)}`;
  }
  return `${inWords(part)}: ${text}${numbers(value, limit, unit)}`;
}

/** Of a motion that goes only a part of the way: what spoke against the whole. */
export const limitText = (limit: Refusal): string => `as far as it goes: ${refusalText(limit)}`;

/** The last few refusals, newest first; one that comes again and again counts up instead. */
export class RefusalLog {
  readonly entries: { text: string; count: number; key: string }[] = [];
  private seen = 0;

  constructor(private readonly length = 5) {}

  /** Takes the newest refusal and their number since the start; true if something changed. */
  add(refusal: Refusal | null, total: number): boolean {
    if (total < this.seen) this.seen = 0; // another run
    if (refusal === null || total === this.seen) return false;
    const count = total - this.seen;
    this.seen = total;
    const key = `${refusal.reason} ${refusal.part} ${refusal.where}`;
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
