import { defineConfig } from 'vite';

/** `npm run dev` shows the page from its sources and asks a running `baton drive` for the rest. */
const program = process.env.BATON_URL ?? 'http://127.0.0.1:8080';

export default defineConfig({
  base: './',
  build: { target: 'es2022', chunkSizeWarningLimit: 1000, assetsInlineLimit: 0 },
  server: {
    host: '127.0.0.1',
    proxy: { '/model.json': program, '/ws': { target: program, ws: true } },
  },
});
