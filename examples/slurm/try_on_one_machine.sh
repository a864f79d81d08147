#!/usr/bin/env bash
# Tries adapt.sbatch with Debian's Slurm on this machine alone: a cluster of one node in a temporary folder, with ports,
# authentication key and spool of its own; nothing outside the folder is changed. Run as root. Packages are installed if
# they are missing (Debian: slurmctld slurmd slurm-client munge); their services are not started.
#
#   examples/slurm/try_on_one_machine.sh [BIN]     BIN holds skein and wingbody_field (build/release/bin)
#
# The case is the wing-body, its "solver" a formula (examples/wingbody). The job is run three times: with mpirun, again
# (nothing is left to do), and with srun where Slurm and Open MPI agree on PMIx (tried, not demanded).
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
bin=$(realpath "${1:-$root/build/release/bin}")
wingbody=$root/examples/wingbody
tasks=2

fail() {
  echo "try_on_one_machine: $*" >&2
  exit 1
}
((EUID == 0)) || fail "must be root: a Slurm daemon starts jobs in the name of their owner"
[[ -x $bin/skein && -x $bin/wingbody_field ]] || fail "$bin has no skein or no wingbody_field; build them first"

install_packages() {
  local missing=()
  command -v slurmctld >/dev/null || missing+=(slurmctld)
  command -v slurmd >/dev/null || missing+=(slurmd)
  command -v sbatch >/dev/null || missing+=(slurm-client)
  command -v munged >/dev/null || missing+=(munge)
  ((${#missing[@]})) || return 0
  command -v apt-get >/dev/null || fail "missing, and not Debian: ${missing[*]}"
  echo "installing ${missing[*]}"
  # RUNLEVEL=1 keeps the packages from starting their services
  { apt-get -qq update && RUNLEVEL=1 DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends \
    "${missing[@]}"; } >/dev/null 2>&1 </dev/null || fail "apt-get failed"
}

free_ports() { # COUNT
  python3 - "$1" <<'EOF'
import socket, sys
sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(int(sys.argv[1]))]
print(*(s.getsockname()[1] for s in sockets))
EOF
}

configure() {
  local ports cpus host memory
  read -r -a ports < <(free_ports 2)
  host=$(hostname -s)
  cpus=$(nproc)
  ((cpus >= tasks)) || cpus=$tasks
  memory=$(awk '/MemAvailable/ { print int($2 / 1024) }' /proc/meminfo)
  mkdir -p "$folder"/{state,spool,munge,log}
  chmod 700 "$folder/munge"
  dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 status=none
  chmod 400 "$folder/munge/key"
  # no control groups (they may be missing in a container), no accounting, no binding
  cat >"$folder/slurm.conf" <<EOF
ClusterName=onemachine
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmdPort=${ports[1]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/log/slurmctld
SlurmdLogFile=$folder/log/slurmd
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$memory State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
EOF
  echo "CgroupPlugin=cgroup/v1" >"$folder/cgroup.conf"
  export SLURM_CONF=$folder/slurm.conf
}

daemons=()
stop_all() {
  local status=$?
  trap - EXIT
  if ((${#daemons[@]})); then
    scancel --user=root 2>/dev/null || true
    sleep 1
    for ((i = ${#daemons[@]} - 1; i >= 0; --i)); do
      kill "${daemons[i]}" 2>/dev/null || true
      wait "${daemons[i]}" 2>/dev/null || true
    done
  fi
  if ((status)); then
    tail -n 15 "$folder"/log/* "$folder"/*.log 2>/dev/null || true
    echo "try_on_one_machine: failed; all logs are in $folder" >&2
  else
    rm -rf "$folder"
  fi
  exit "$status"
}

start() { # NAME COMMAND...
  local name=$1
  shift
  "$@" >"$folder/log/$name.out" 2>&1 </dev/null &
  daemons+=($!)
}

await() { # SECONDS WHAT COMMAND...: until the command succeeds
  local seconds=$1 what=$2
  shift 2
  for ((i = 0; i < 5 * seconds; ++i)); do
    "$@" && return 0
    sleep 0.2
  done
  fail "$what did not come up in $seconds s"
}
munge_answers() { munge --socket "$folder/munge/socket" -n >/dev/null 2>&1; }
node_is_idle() { [[ $(sinfo -h -o %T 2>/dev/null) == idle ]]; }

start_cluster() {
  # --force: as root, which a daemon for one job of root may be
  start munged munged --foreground --force --key-file "$folder/munge/key" --socket "$folder/munge/socket" \
    --pid-file "$folder/munge/pid" --log-file "$folder/log/munged" --seed-file "$folder/munge/seed"
  await 10 munged munge_answers
  start slurmctld slurmctld -D -i
  start slurmd slurmd -D
  await 30 "the node" node_is_idle
  sinfo -N -l
}

job_state() { scontrol show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p'; }

run_job() { # NAME VARIABLES...: runs adapt.sbatch; its exit code
  local name=$1 id state
  shift
  id=$(cd "$folder" && env "$@" sbatch --parsable --job-name="$name" --ntasks-per-node="$tasks" --time=10 "$here/adapt.sbatch")
  echo "job $id ($name) submitted"
  for ((i = 0; i < 600; ++i)); do
    state=$(job_state "$id")
    case $state in
      COMPLETED) return 0 ;;
      FAILED | CANCELLED | TIMEOUT | NODE_FAIL | OUT_OF_MEMORY) echo "job $id ($name) ended as $state"; return 1 ;;
    esac
    sleep 1
  done
  fail "job $id is still $state after 600 s"
}

install_packages
folder=$(mktemp -d "${TMPDIR:-/tmp}/skein-slurm-XXXXXX")
trap stop_all EXIT
trap 'exit 130' INT TERM
configure
start_cluster

"$bin/skein" generate "$wingbody/surface.meshb" --sources "$wingbody/sources.toml" -o "$folder/volume.meshb" --quiet
case_variables=("SKEIN=$bin/skein" "SOLVER=$bin/wingbody_field" "MESH=$folder/volume.meshb" "COMPLEXITIES=3000 6000"
  "ADAPT_OPTIONS=--hmax 40" OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1)

run_job with-mpirun "${case_variables[@]}" "WORK=$folder/run" || fail "the job with mpirun failed"
cat "$folder"/with-mpirun-*.log
"$bin/skein" check "$folder/run/pass_2.meshb"
grep -q "\"ranks\": $tasks" "$folder/run/pass_2.json" || fail "the job did not run on $tasks ranks"

run_job again "${case_variables[@]}" "WORK=$folder/run" || fail "the second job failed"
[[ $(grep -c "is there" "$folder"/again-*.log) == 2 ]] || fail "the second job did its passes again"

if srun --mpi=list 2>&1 | grep -q pmix &&
  run_job with-srun "${case_variables[@]}" "WORK=$folder/run-srun" "LAUNCH=srun --mpi=pmix"; then
  cmp "$folder/run/pass_2.meshb" "$folder/run-srun/pass_2.meshb" || fail "srun gave another mesh than mpirun"
  echo "srun --mpi=pmix: the same mesh"
else
  echo "srun --mpi=pmix: does not work here; mpirun does"
  tail -n 5 "$folder"/with-srun-*.log 2>/dev/null || true
fi
echo "ok: the batch script works with $(slurmctld -V) on one node"
