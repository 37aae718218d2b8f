#!/bin/sh
# Bundles src/ into dist/page.html, the template that `quoin view` fills. Needs `npm ci --ignore-scripts`.
set -e
cd "$(dirname "$0")"
out=${1:-dist/page.html}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
node_modules/.bin/esbuild src/viewer.js --bundle --minify --format=iife --target=es2022 --charset=utf8 \
  --legal-comments=none --log-level=warning --outfile="$work/viewer.js"
node -e '
const fs = require("fs"), read = (path) => fs.readFileSync(path, "utf8");
const licences = ["three", "uplot"].map((name) => name + "\n" + read("node_modules/" + name + "/LICENSE").trim()).join("\n\n");
const fill = {PLOT_STYLE: read("node_modules/uplot/dist/uPlot.min.css").trim(),
              SCRIPT: "/*\n" + licences + "\n*/\n" + read(process.argv[1]).trim()};
const page = read("src/page.html").replace(/@(PLOT_STYLE|SCRIPT)@/g, (_, name) => fill[name]);
fs.writeFileSync(process.argv[2], page);
' "$work/viewer.js" "$out"
