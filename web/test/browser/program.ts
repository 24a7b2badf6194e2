/** The program and the browser that the tests bring together. */
import { spawn, type ChildProcess } from 'node:child_process';
import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium, type Browser, type Page } from 'playwright-core';

export const path = (relative: string): string => fileURLToPath(new URL(relative, import.meta.url));
export const patience = { timeout: 60_000 };
export const program = process.env.BATON ?? path('../../../build/release/baton');

/** Starts the program; the address is the one that it prints. */
export function start(options: string): Promise<{ run: ChildProcess; url: string }> {
  if (!existsSync(program)) throw new Error(`there is no program ${program}: build it, or name it in $BATON`);
  const args = `drive --input page --seconds 600 --port 0 ${options}`.split(' ');
  const run = spawn(program, args, { stdio: ['ignore', 'pipe', 'pipe'] });
  return new Promise((resolve, reject) => {
    let output = '';
    const listen = (text: Buffer): void => {
      output += text.toString();
      const found = /page at (http:\S+)/.exec(output);
      if (found) resolve({ run, url: found[1]! });
    };
    run.stdout.on('data', listen);
    run.stderr.on('data', listen);
    run.on('error', reject);
    run.on('exit', (code) => reject(new Error(`the program ended (${code}): ${output}`)));
  });
}

export async function stop(run?: ChildProcess): Promise<void> {
  if (!run || run.exitCode !== null) return;
  const ended = new Promise((resolve) => run.on('exit', resolve));
  run.kill('SIGINT');
  await ended;
}

export function launch(): Promise<Browser> {
  const args = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--no-first-run'];
  const quiet = [
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--disable-quic',
  ];
  const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
  return chromium.launch({ executablePath, headless: true, args: [...args, ...quiet] });
}

export const role = (of: Page, wanted: string): Promise<unknown> =>
  of.waitForFunction((name) => document.getElementById('role')!.dataset.role === name, wanted, patience);

/** Waits until the page tells programs that the robot does this. */
export const does = (page: Page, activity: string): Promise<unknown> =>
  page.waitForSelector(`body[data-state="${activity}"]`, patience);
