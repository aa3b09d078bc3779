#!/usr/bin/env bash
# The tests use a PostgreSQL server, a browser, SQLite's shell, strace, a C compiler, R and LaTeX. With CI=true or LABBOOK_INSTALL=1 they are installed where this
# user may; otherwise one line says what is skipped and how to have it.
set -u
missing=()
ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || missing+=(postgresql)
command -v chromium >/dev/null 2>&1 || missing+=(chromium)
command -v sqlite3 >/dev/null 2>&1 || missing+=(sqlite3)
command -v strace >/dev/null 2>&1 || missing+=(strace)
command -v cc >/dev/null 2>&1 || missing+=(gcc libc6-dev)
command -v Rscript >/dev/null 2>&1 || missing+=(r-base-core r-cran-rsqlite)
command -v pdflatex >/dev/null 2>&1 || missing+=(texlive-latex-base texlive-latex-recommended)
[ "${#missing[@]}" -eq 0 ] && exit 0

if [ "${CI:-}" = true ] || [ "${LABBOOK_INSTALL:-}" = 1 ]; then
  as_root=()
  [ "$(id -u)" -eq 0 ] || as_root=(sudo -n)
  if command -v apt-get >/dev/null 2>&1 && "${as_root[@]}" true 2>/dev/null; then
    echo "== installing ${missing[*]}"
    if "${as_root[@]}" apt-get update -qq >/dev/null &&
      DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null; then
      exit 0
    fi
    echo "== installing ${missing[*]} failed: their tests are skipped"
    exit 0
  fi
fi
echo "== skipped: tests that need ${missing[*]}; to have them: LABBOOK_INSTALL=1 make test (Debian), or install them"
