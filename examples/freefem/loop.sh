#!/usr/bin/env bash
# Solve with FreeFem++, adapt with Skein, and again (README.md). Needs freefem++ and libfreefem++ (Debian).
#
#   loop.sh [FOLDER]     makes its files in FOLDER (default: a new one); SKEIN: the program, RANKS: processes (2)
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
skein=${SKEIN:-skein}
run=(${SKEIN_MPIRUN:-mpirun} -n "${RANKS:-2}" "$skein")
export FF_LOADPATH=${FF_LOADPATH:-/usr/lib/freefem++} # where Debian has the plug-ins
folder=${1:-$(mktemp -d)}
mkdir -p "$folder"
cd "$folder"

"${run[@]}" generate "$here/../loop/cube.mesh" --size-max 0.2 -o mesh0.meshb --quiet
for i in 0 1 2 3; do
  FreeFem++ -nw -v 0 "$here/solve.edp" "mesh$i.meshb" "u$i.solb"
  ((i == 3)) || "${run[@]}" adapt "mesh$i.meshb" --field "u$i.solb" --elements 20000 -o "mesh$((i + 1)).meshb" --quiet
done
