#!/usr/bin/env bash
# Converts scans with a Slurm of its own on this machine, kills tasks meanwhile, sends the array again,
# and compares the bytes with a run without Slurm. It needs root, and Debian's slurmctld, slurmd,
# slurm-client and munge. It stops what it has started.
#
#     benches/engines/run_slurm.sh PYTHON
#
# PYTHON has the package scan2step, which makes the scans. The program is target/release/scan2step.
set -euo pipefail
cd "$(dirname "$0")/../.."
python=$1
program=$PWD/target/release/scan2step
work=$(mktemp -d)
export SLURM_CONF=$work/slurm.conf
pids=()
stop() {
    kill "${pids[@]}" 2>/dev/null || true
    wait 2>/dev/null || true
    rm -rf "$work"
}
trap stop EXIT

start() { # PROGRAM ARGUMENT...
    "$@" >"$work/$(basename "$1").log" 2>&1 &
    pids+=($!)
}
mkdir -p "$work"/{munge,state,spool,scans}
dd if=/dev/urandom of="$work/munge/key" bs=1024 count=1 status=none
chmod -R 700 "$work/munge"
chmod 755 "$work" # munged wants the way to its socket open
start munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge.socket" \
    --pid-file="$work/munge/pid" --log-file="$work/munge/log" --seed-file="$work/munge/seed"
host=$(hostname -s)
cat >"$SLURM_CONF" <<CONF
ClusterName=scans
SlurmctldHost=$host(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CryptoType=crypto/munge
SlurmUser=root
SlurmctldPort=26817
SlurmdPort=26818
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
ReturnToService=2
MpiDefault=none
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES State=UP
CONF
start slurmctld -D
start slurmd -D
for _ in $(seq 100); do
    sinfo -h -o %T 2>/dev/null | grep -q idle && break
    sleep 0.2
done

"$python" -c "
import sys; sys.path.insert(0, 'benches/engines')
from pathlib import Path; import common
common.scans(Path('$work/scans'))"
options=(--tolerance 0.6 --quiet)
"$program" batch "$work/scans" --out "$work/alone" "${options[@]}" >/dev/null 2>&1 || true

cat >"$work/job" <<JOB
#!/bin/bash
exec $program batch $work/scans --out $work/slurm --shard \$SLURM_ARRAY_TASK_ID/4 --threads \$SLURM_CPUS_PER_TASK ${options[*]}
JOB
array() { # sends the array and waits until it has ended
    sbatch --quiet --wait --array=1-4 --cpus-per-task=1 --output="$work/%A_%a.out" "$work/job" || true
}
array &
waiting=$!
until ls "$work/slurm"/*.step >/dev/null 2>&1; do sleep 0.05; done
for _ in 1 2 3; do
    sleep "0.$((RANDOM % 7 + 1))"
    pkill -9 -f "batch $work/scans --out $work/slurm" -o || true
done
wait $waiting
begun=$(find "$work/slurm" -name '*.step' | wc -l)
find "$work/slurm" -name '*.step' -printf '%f %T@\n' | sort >"$work/before"
array
"$program" batch "$work/scans" --out "$work/slurm" "${options[@]}" >/dev/null 2>&1 || true
find "$work/slurm" -name '*.step' -printf '%f %T@\n' | sort >"$work/after"
# A task that is killed between its file and its record does the scan again.
again=$(comm -23 "$work/before" "$work/after" | wc -l)
left=$(find "$work/slurm" -name '*.part' | wc -l)
for file in "$work/alone"/*.step; do cmp "$file" "$work/slurm/$(basename "$file")"; done
count=$(find "$work/slurm" -name '*.step' | wc -l)
rows=$(($(wc -l <"$work/slurm/summary.csv") - 1))
echo "Slurm: $begun files when tasks were killed, then $count, $rows rows, $left half files, $again begun twice; bytes as on one machine"
[ "$count" = 24 ] && [ "$rows" = 25 ] && [ "$left" = 0 ] && [ "$again" -le 3 ]
