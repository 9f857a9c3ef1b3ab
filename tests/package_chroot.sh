#!/usr/bin/env bash
# Installs the Debian packages of BUILD_DIR in a fresh Debian 12 that has nothing else (debootstrap), and
# uses them there: package_chroot.sh BUILD_DIR. Needs root and the network; `./run package` calls it.
set -euo pipefail
build="$(realpath -- "$1")"
root="$(mktemp -d)"
clean_up() {
  umount "$root/proc" 2>/dev/null || true
  rm -rf -- "$root"
}
trap clean_up EXIT
# The mirror and keys that this machine uses.
mirror="$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | head -n 1)"
debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root.log" 2>&1 || { tail -n 20 "$root.log"; exit 1; }
rm -rf "$root/etc/apt"
cp -r /etc/apt "$root/etc/apt"
cp /etc/resolv.conf "$root/etc/resolv.conf"
mount -t proc proc "$root/proc" 2>/dev/null || true
cp "$build"/burin_*.deb "$build"/python3-burin_*.deb "$root/tmp/"
inside() { chroot "$root" env DEBIAN_FRONTEND=noninteractive HOME=/root LC_ALL=C "$@"; }
inside apt-get -qq -o APT::Sandbox::User=root update
inside sh -c 'apt-get -qq -y --no-install-recommends install /tmp/burin_*.deb' >"$root.log" 2>&1 ||
  { tail -n 20 "$root.log"; exit 1; }
inside burin --version
inside burin demo --output /tmp/demo | grep 'RMSE to truth'
inside sh -c 'apt-get -qq -y --no-install-recommends install /tmp/python3-burin_*.deb' >"$root.log" 2>&1 ||
  { tail -n 20 "$root.log"; exit 1; }
inside python3 -c '
import burin
scene = burin.load_scene("/tmp/demo/scene")
mesh = burin.read_mesh("/tmp/demo/scene/init.ply")
result = burin.refine(scene, *mesh, burin.Options({"level.finest": 2}))
print("python3-burin:", len(result.faces), "faces")'
rm -f "$root.log"
