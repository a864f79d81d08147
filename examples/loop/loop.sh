#!/usr/bin/env bash
# From a surface to a mesh that fits its solution: generate, then solve and adapt in turn (docs/tutorial.md).
#
#   loop.sh [FOLDER]     makes its files in FOLDER (default: a new one); SKEIN: the program, RANKS: processes (2)
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
skein=${SKEIN:-skein}
run=(${SKEIN_MPIRUN:-mpirun} -n "${RANKS:-2}" "$skein")
folder=${1:-$(mktemp -d)}
mkdir -p "$folder"
cd "$folder"

"${run[@]}" generate "$here/cube.mesh" --size-max 0.15 -o mesh0.mesh --quiet
for i in 0 1 2 3; do
  echo -n "mesh $i: "
  python3 "$here/solve.py" "mesh$i.mesh" "u$i.sol"
  ((i == 3)) || "${run[@]}" adapt "mesh$i.mesh" --field "u$i.sol" --elements 20000 --hmin 0.001 \
    -o "mesh$((i + 1)).mesh" --report "report$((i + 1)).json" --quiet
done
"$skein" convert mesh3.mesh picture.vtu --with u3.sol
