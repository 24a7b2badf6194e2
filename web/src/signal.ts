/** Detects loss of signal from the program, with an injected clock. Independent of the browser. */

/** Longest gap between states, which the program sends 30 times a second [ms]. */
export const silence = 500;

export class Signal {
  private heardAt: number | null = null;

  heard(now: number): void {
    this.heardAt = now;
  }

  /** The connection is closed, which is reported separately. */
  closed(): void {
    this.heardAt = null;
  }

  /** Connected, but no data arrives. */
  lost(now: number): boolean {
    return this.heardAt !== null && now - this.heardAt > silence;
  }
}
