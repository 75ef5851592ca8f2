#!/bin/sh
# Tests the packages on a minimal Debian: installs them with apt, starts a server as its unit does,
# and queries it with the command line and with Python. Needs root, mmdebstrap and the same Debian
# sources as the machine has.
#   test.sh FOLDER_WITH_PACKAGES
set -eu
packages=$(readlink -f "$1")
root=$(mktemp -d /var/tmp/cwm-package-test.XXXXXX)
server=
finish() {
  [ -z "$server" ] || kill "$server" 2>/dev/null || true
  [ -z "$server" ] || wait "$server" 2>/dev/null || true
  rm -rf --one-file-system "$root"
}
trap finish EXIT

fail() {
  echo "package test: $*" >&2
  exit 1
}
# Replaces the shell, so that the background process killed at the end is the program itself.
become() { exec chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root CWM_ADDR=unix:/run/cwm/cwm.sock "$@"; }
inside() { (become "$@"); }

# apt installs the packages with their dependencies, without recommended packages. Unlike on other
# minimal systems the documentation is kept, because manual pages are checked.
set -- "$packages"/*.deb
[ -f "$1" ] || fail "no packages in $packages"
for package in "$@"; do
  case $(dpkg-deb -f "$package" Maintainer) in
    *@localhost\>*) fail "$package names a maintainer who is on every machine another" ;;
    *\<*@*.*\>) ;;
    *) fail "$package has no maintainer: $(dpkg-deb -f "$package" Maintainer)" ;;
  esac
done
mmdebstrap --quiet --mode=root --variant=apt --aptopt='APT::Install-Recommends "false"' \
  --customize-hook='mkdir -p "$1/packages"' --customize-hook="cp $packages/*.deb \"\$1/packages\"" \
  --customize-hook='chroot "$1" sh -c "apt-get update -qq && apt-get install -y -qq /packages/*.deb"' \
  bookworm "$root" "${CWM_APT_SOURCES:-/etc/apt/sources.list.d/debian.sources}" >"$root.log" 2>&1 ||
  { tail -40 "$root.log" >&2; rm -f "$root.log"; fail "the packages cannot be installed"; }
rm -f "$root.log"

inside id cwm >/dev/null || fail "the user cwm is missing"
for file in etc/default/cwm-server usr/lib/systemd/system/cwm-server.service usr/share/man/man8/cwm-server.8.gz \
  usr/share/man/man1/cwm.1.gz usr/share/man/man1/cwm-plan.1.gz usr/share/man/man1/cwm-simulator.1.gz \
  usr/share/doc/cwm-server/copyright usr/share/doc/cwm-server/three.js.LICENSE usr/share/doc/cwm-cli/three.js.LICENSE \
  usr/share/bash-completion/completions/cwm usr/share/zsh/vendor-completions/_cwm usr/share/fish/vendor_completions.d/cwm.fish \
  usr/include/cwm/client.h; do
  [ -s "$root/$file" ] || fail "/$file is missing"
done
gzip -dc "$root/usr/share/man/man1/cwm.1.gz" | grep -q '^.SS ingest' || fail "cwm(1) does not tell of ingest"

# Does what the unit does, which needs a running systemd: the user, its folders, the socket, the
# options of /etc/default.
unit=$root/usr/lib/systemd/system/cwm-server.service
store=$(sed -n 's/^Environment=CWM_STORE=//p' "$unit")
[ "$store" = sqlite:/var/lib/cwm ] || fail "the unit keeps worlds in \"$store\""
inside install -d -o cwm -g cwm /run/cwm
inside install -d -o cwm -g cwm -m 0700 /var/lib/cwm
start() {
  become setpriv --reuid=cwm --regid=cwm --init-groups env CWM_STORE="$store" \
    sh -c '. /etc/default/cwm-server; exec /usr/bin/cwm-server $CWM_SERVER_OPTIONS --viewer off' &
  server=$!
  for _ in $(seq 100); do inside cwm status >/dev/null 2>&1 && return; sleep 0.1; done
  fail "the server does not serve"
}
start

inside cwm-simulator --out /tmp/scan.pcd
inside cwm ingest /tmp/scan.pcd >/dev/null || fail "a scan cannot be ingested"
inside cwm objects -o ndjson >"$root/tmp/objects"
[ "$(wc -l <"$root/tmp/objects")" -ge 3 ] || fail "the demo's scan has fewer than 3 objects: $(cat "$root/tmp/objects")"
inside cwm distance --box 0.1,0.08,0.2 --at 0.4,0,0.3 -o json | grep -q distance || fail "no distance"
objects=$(inside python3 -c 'import cwm
with cwm.connect() as world: print(len(world.objects()))')
[ "$objects" = "$(wc -l <"$root/tmp/objects")" ] || fail "Python sees $objects objects"

inside cwm put kept_crate --box 0.3,0.2,0.2 --at 0,0,9 >/dev/null || fail "no object can be put"
inside cwm backup /tmp/backup >/dev/null || fail "the store cannot be backed up"
kill "$server" && wait "$server" || fail "the server does not end by itself"
start
inside cwm get kept_crate >/dev/null || fail "a restart loses an object"
kill "$server" && wait "$server" || fail "the server does not end by itself"
server=
inside cwm store check /var/lib/cwm >/dev/null || fail "the store is damaged"
inside cwm restore /tmp/backup /tmp/restored >/dev/null || fail "the backup cannot be restored"

inside apt-get purge -y -qq cwm-server >/dev/null 2>&1 || fail "cwm-server cannot be removed"
[ ! -e "$root/etc/default/cwm-server" ] || fail "/etc/default/cwm-server outlives a purge"
[ -s "$root/var/lib/cwm/store.db" ] || fail "a purge removes the worlds"
echo "packages: ok, installed on a minimal Debian, $objects objects seen there"
