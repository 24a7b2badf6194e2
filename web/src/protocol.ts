/** The messages between server and page (docs/page.md). */

export const parts = ['left_foot', 'right_foot', 'left_hand', 'right_hand', 'trunk'] as const;
export type Part = (typeof parts)[number];

export const isFoot = (part: Part): boolean => part.endsWith('_foot');

/** "left_foot" → "left foot" */
export const inWords = (name: string): string => name.replaceAll('_', ' ');

/** Active while held: go back the way it came; step to the initial stance; come to rest as quickly as possible. */
export type Recall = 'none' | 'retrace' | 'home' | 'stop';

/** The recall in force: stop wins, then retrace. */
export const oneOf = (held: Iterable<Recall>): Recall => {
  const all = new Set(held);
  return (['stop', 'retrace', 'home'] as const).find((recall) => all.has(recall)) ?? 'none';
};

/** What the page asks for: x forward, y left, z up, roll, pitch, yaw in −1…1; lift of each foot in 0…1. */
export interface Command {
  guide: Part;
  axes: number[];
  lift: [number, number];
  recall: Recall;
  deadman: boolean;
}

/** A number, or null where the program has none. */
export type Value = number | null;

export interface Refusal {
  reason: string;
  part: string;
  value: Value;
  limit: Value;
  where: string;
  cause: string | null; // underlying reason, which value and limit then refer to
}

export interface Goal {
  kind: string;
  guided: Part;
  swing: 'left' | 'right' | null;
  soles: [Value[][], Value[][]]; // corners of the left and the right sole [m]
  hands: [Value[] | null, Value[] | null]; // x y z qw qx qy qz
  com: Value[];
}

/** What the robot is doing; `waiting`: unknown. */
export type Activity = 'rest' | 'moving' | 'stopping' | 'retracing' | 'fallen' | 'waiting';

/** A part that was refused repeatedly at the same rest, and the ways out. */
export interface Stuck {
  part: Part;
  times: number; // in a row
  retrace: boolean;
  home: boolean;
}

export interface State {
  type: 'state';
  state: Activity;
  role: 'driver' | 'watcher';
  taken: boolean;
  t: number;
  bodies: Value[][]; // x y z qw qx qy qz of every body
  guide: Part;
  axes: Value[];
  lift: Value[];
  recall: Recall;
  device: { name: string; connected: boolean; armed: boolean; hint: string };
  goal: Goal | null;
  segment: { time: Value; duration: Value };
  limit: Refusal | null; // why the motion does only part of the request, if so
  history: number; // number of motions that can be retraced
  contact: [boolean, boolean];
  support: Value[][];
  support_height: Value;
  com: Value[];
  zmp: Value[];
  dcm: Value[];
  refusal: Refusal | null;
  refusals: number;
  stuck: Stuck | null;
  message: string;
  damps: boolean; // the robot can be damped: its motors only brake then
}

export interface Geom {
  name: string;
  body: number;
  type: 'plane' | 'sphere' | 'capsule' | 'ellipsoid' | 'cylinder' | 'box' | 'mesh';
  size: [number, number, number];
  pos: [number, number, number];
  quat: [number, number, number, number]; // w x y z
  rgba: [number, number, number, number];
  shine: number;
  mesh?: number;
}

/** /model.json */
export interface Model {
  robot: string;
  world: string;
  size: number; // nominal height of the centre of mass [m]
  parts: { name: Part; body: number }[];
  bodies: { name: string; parent: number }[];
  geoms: Geom[];
  meshes: { name: string; vertices: string; faces: string }[];
  sites: { name: string; pos: [number, number, number]; visible: boolean }[];
}

/** Whether all elements are numbers. */
export const finite = (values: Value[]): values is number[] => values.every((value) => value !== null);
