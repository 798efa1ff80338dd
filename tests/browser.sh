#!/bin/sh
# Sees to it that the tests find a Chromium: sh tests/browser.sh PYTHON. Where none can be had, says so; those tests are
# skipped then.
"$1" "$(dirname "$0")/python/browser.py" && exit 0
"$1" -m playwright install chromium >/dev/null 2>&1 && exit 0
# A fresh Debian machine of a build server: its own package.
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
	(apt-get update && apt-get install --yes --no-install-recommends chromium) >/dev/null 2>&1 && exit 0
fi
echo "no browser could be installed: the tests that need one are skipped; install Chromium or set CHROMIUM to one"
