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

# Does what the unit does, which needs a running systemd: the user, its folder, the socket, the
# options of /etc/default.
inside install -d -o cwm -g cwm /run/cwm
become setpriv --reuid=cwm --regid=cwm --init-groups \
  sh -c '. /etc/default/cwm-server; exec /usr/bin/cwm-server $CWM_SERVER_OPTIONS --viewer off' &
server=$!
for _ in $(seq 100); do [ -S "$root/run/cwm/cwm.sock" ] && break; sleep 0.1; done
[ -S "$root/run/cwm/cwm.sock" ] || fail "the server does not listen"

inside cwm-simulator --out /tmp/scan.pcd
inside cwm ingest /tmp/scan.pcd >/dev/null || fail "a scan cannot be ingested"
inside cwm objects -o ndjson >"$root/tmp/objects"
[ "$(wc -l <"$root/tmp/objects")" -ge 3 ] || fail "the demo's scan has fewer than 3 objects: $(cat "$root/tmp/objects")"
inside cwm distance --box 0.1,0.08,0.2 --at 0.4,0,0.3 -o json | grep -q distance || fail "no distance"
objects=$(inside python3 -c 'import cwm
with cwm.connect() as world: print(len(world.objects()))')
[ "$objects" = "$(wc -l <"$root/tmp/objects")" ] || fail "Python sees $objects objects"

inside apt-get purge -y -qq cwm-server >/dev/null 2>&1 || fail "cwm-server cannot be removed"
[ ! -e "$root/etc/default/cwm-server" ] || fail "/etc/default/cwm-server outlives a purge"
echo "packages: ok, installed on a minimal Debian, $objects objects seen there"
