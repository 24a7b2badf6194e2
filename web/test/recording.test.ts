// A recording, judged by MCAP's own reader in TypeScript.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { McapIndexedReader, McapStreamReader, type McapTypes } from '@mcap/core';
import { decompress } from 'fzstd';
import { afterAll, beforeAll, describe, expect, test } from 'vitest';
import { program } from './browser/program';

const decompressHandlers: McapTypes.DecompressHandlers = { zstd: (data) => decompress(data) };

describe('a recording of two seconds', () => {
  let folder = '';
  let file: Uint8Array;

  beforeAll(() => {
    if (!existsSync(program)) throw new Error(`there is no program ${program}: build it, or name it in $BATON`);
    folder = mkdtempSync(join(tmpdir(), 'baton-'));
    const recording = join(folder, 'run.mcap');
    const drive = ['drive', '--headless', '--fast', '--on', 'ideal', '--world', 'flat', '--seconds', '2'];
    execFileSync(program, [...drive, '--record', recording], { stdio: 'pipe' });
    file = readFileSync(recording);
  });
  afterAll(() => rmSync(folder, { recursive: true, force: true }));

  test('has each message in its index, in the order of time', async () => {
    const readable: McapTypes.IReadable = {
      size: () => Promise.resolve(BigInt(file.length)),
      read: (offset, size) => Promise.resolve(file.subarray(Number(offset), Number(offset + size))),
    };
    const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
    const counts = new Map<number, bigint>();
    let last = -1n;
    for await (const message of reader.readMessages()) {
      expect(message.logTime >= last).toBe(true);
      last = message.logTime;
      counts.set(message.channelId, (counts.get(message.channelId) ?? 0n) + 1n);
    }
    const stated = [...(reader.statistics?.channelMessageCounts ?? [])].filter(([, count]) => count > 0n);
    expect(counts).toEqual(new Map(stated));
    const topics = new Map([...reader.channelsById].map(([id, channel]) => [channel.topic, counts.get(id) ?? 0n]));
    for (const topic of ['/joint_states', '/joint_targets', '/imu', '/sole/left', '/sole/right', '/baton/tick'])
      expect(topics.get(topic), topic).toBe(400n);
    for (const channel of reader.channelsById.values())
      expect(['cdr', 'json']).toContain(channel.messageEncoding);
  });

  test('has right checksums, and a schema for each channel', () => {
    const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
    reader.append(file);
    const schemas = new Map<number, string>();
    let messages = 0;
    for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
      if (record.type === 'Schema') schemas.set(record.id, record.encoding);
      if (record.type === 'Channel') expect(['ros2msg', 'jsonschema']).toContain(schemas.get(record.schemaId));
      if (record.type === 'Message') ++messages;
    }
    expect(reader.done()).toBe(true);
    expect(messages).toBeGreaterThan(6 * 400);
  });
});
