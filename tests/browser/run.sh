#!/bin/sh
# Checks the report's front end and opens its pages in a real browser. Skips, with a message, what the machine lacks.
# Set RETUNE_BROWSER=required to make a missing Node.js or Chromium an error, RETUNE_PAGES=made where `cargo test` has just written the pages.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)

skip() {
    echo "browser tests skipped: $1"
    [ "${RETUNE_BROWSER:-}" = required ] && exit 1
    exit 0
}
command -v node >/dev/null 2>&1 && command -v npm >/dev/null 2>&1 || skip "no Node.js with npm here"

echo "== front end: types, arithmetic, and whether dist/ is what its sources give"
cd "$root/report/web"
npm ci --silent --no-audit --no-fund || skip "npm cannot install the front end's packages"
npm run --silent check
npm run --silent test

if [ "${RETUNE_PAGES:-}" != made ]; then
    echo "== pages of the fixture"
    cd "$root"
    # Of all packages, as `cargo test` alone compiles them: with other features each would be compiled once more.
    cargo test --release --quiet --lib fixture
    cargo test --release --quiet --test all live::
fi

[ -n "${CHROMIUM:-}" ] || [ -x /usr/bin/chromium ] || [ -x /usr/bin/chromium-browser ] || [ -x /usr/bin/google-chrome ] ||
    skip "no Chromium here (Debian: apt-get install chromium; or set CHROMIUM)"
echo "== pages in Chromium"
cd "$here"
npm ci --silent --no-audit --no-fund || skip "npm cannot install playwright-core"
node --test --test-reporter=spec report.test.mjs live.test.mjs
