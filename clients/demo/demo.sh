#!/usr/bin/env bash
# The product in one minute: a server, a scan, what it made of it, three questions. Called by `./dev demo`.
#   demo.sh ONCE [CLOUD]     ONCE 1: end after printing; CLOUD: a PCD or PLY file, else a kitchen from the virtual scanner
set -euo pipefail
once=$1 cloud=${2:-}
bin=${CWM_BIN:-$PWD/build/bin}
scratch=$(mktemp -d)
socket=$scratch/cwm.sock
server=

cleanup() {
  [ -n "$server" ] && kill "$server" 2>/dev/null && wait "$server" 2>/dev/null
  rm -rf "$scratch"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

show() {  # the command as the user would type it, then what it prints
  printf '\n$ cwm %s\n' "$*"
  "$bin/cwm" --addr "unix:$socket" "$@"
}

pose=()
if [ -z "$cloud" ]; then
  cloud=$scratch/kitchen.pcd
  echo "A virtual Kinect scans a kitchen counter (what really stands there: $scratch/truth.json)"
  "$bin/cwm-simulator" --scene kitchen --sensor kinect --seed 1 --out "$cloud" --truth "$scratch/truth.json"
  pose=(--x-world-sensor "$("$bin/cwm-simulator" --scene kitchen --print-pose)")
fi

"$bin/cwm-server" --listen "unix:$socket" 2>"$scratch/server.log" &
server=$!
for _ in $(seq 100); do
  "$bin/cwm" --addr "unix:$socket" status >/dev/null 2>&1 && break
  kill -0 "$server" 2>/dev/null || { cat "$scratch/server.log" >&2 && exit 1; }
  sleep 0.1
done

show status
show ingest "$cloud" ${pose[@]+"${pose[@]}"}
show objects

one=$("$bin/cwm" --addr "unix:$socket" -o ndjson objects --kind object | sed -n '$s/.*"name":[ ]*"\([^"]*\)".*/\1/p')
if [ -n "$one" ]; then
  printf '\nHow far is a gripper-sized box, 20 cm above %s, from everything else?' "$one"
  show distance --box 0.10,0.20,0.06 --at "$one+0,0,0.20"
  printf '\nWhat does a sphere of 5 cm touch, put where %s is?' "$one"
  show contacts --sphere 0.05 --at "$one"
  printf '\nWhat does a ray meet that comes down on %s from 1 m above?' "$one"
  show ray --from "$one+0,0,1" --direction 0,0,-1
fi

[ "$once" = 1 ] && exit 0
cat <<TEXT

The server stays up until you press Ctrl-C.
$(sed -n 's/^cwm-server .*shows the world at \(http[^ ]*\).*/Look at it live in a browser: \1/p' "$scratch/server.log")
From another terminal:
  export CWM_ADDR=unix:$socket PATH=$bin:\$PATH
  cwm objects                                     what stands there
  cwm put crate --box 0.3,0.2,0.2 --at 0,0,1      add an object of yours
  cwm distance --sphere 0.03 --at 0,0,1.2         ask
  cwm watch                                       see every change as it happens
  cwm --help
TEXT
wait "$server"
