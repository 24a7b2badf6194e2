/** Whether the program is heard, by a clock that is passed in. Knows nothing of the browser. */

/** So long nothing may come from the program, which tells its state 30 times a second [ms]. */
export const silence = 500;

export class Signal {
  private heardAt: number | null = null;

  heard(now: number): void {
    this.heardAt = now;
  }

  /** The connection is closed, which is told in other words. */
  closed(): void {
    this.heardAt = null;
  }

  /** The connection stands, and nothing comes through. */
  lost(now: number): boolean {
    return this.heardAt !== null && now - this.heardAt > silence;
  }
}
