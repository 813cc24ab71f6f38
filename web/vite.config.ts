// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { defineConfig } from "vitest/config";

// File names without hashes: cmake/EmbedWeb.cmake lists them.
export default defineConfig({
  base: "./",
  build: {
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      input: { page: "index.html", sw: "src/sw.ts", unpacker: "src/view/unpacker.ts" },
      output: { entryFileNames: "[name].js", assetFileNames: "page[extname]" },
    },
  },
  test: { include: ["test/**/*.test.ts"] },
});
