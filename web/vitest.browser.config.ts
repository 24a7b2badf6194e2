import { defineConfig } from 'vitest/config';

export default defineConfig({
  test: {
    include: ['test/browser/*.test.ts'],
    testTimeout: 120_000,
    hookTimeout: 120_000,
    retry: 1, // a live page and a live robot: a busy machine may stall either
    fileParallelism: false,
  },
});
