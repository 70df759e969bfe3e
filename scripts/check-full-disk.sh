#!/usr/bin/env bash
# Every writer of the command line on a disk that is full: a small tmpfs, mounted where nobody else sees it. Each has to end with an
# error that names the file, leave what was there as it was, and leave nothing else behind. Called by .ci/run.
#
# scripts/check-full-disk.sh [PROGRAM]; needs Linux, and root or user namespaces. Where neither is to be had it fails, and says so;
# EXTRICATE_NO_TMPFS=1 goes on without, and says that too. The tests of the command line (faults.rs) need neither: they limit the
# size of files.
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-${CARGO_TARGET_DIR:-target}/debug/extricate}")

if [ "${IN_NAMESPACE:-}" != 1 ]; then
    as_root=()
    if [ "$(id -u)" != 0 ]; then as_root=(--map-root-user); fi
    if ! unshare "${as_root[@]}" --mount true 2>/dev/null; then
        echo "full disk: NOT CHECKED: this system lets no tmpfs be mounted (it takes Linux, and root or user namespaces)" >&2
        [ "${EXTRICATE_NO_TMPFS:-}" = 1 ] && exit 0
        echo "set EXTRICATE_NO_TMPFS=1 to go on without" >&2
        exit 1
    fi
    export IN_NAMESPACE=1
    exec unshare "${as_root[@]}" --mount "$0" "$program"
fi

work=$(mktemp -d)
trap 'umount "$work/full" 2>/dev/null; rm -rf "$work"' EXIT
mkdir "$work/full"
mount -t tmpfs -o size=4m tmpfs "$work/full"
cd "$work"
"$program" demo --scene planar-arm --export scenes >/dev/null
scene=$(echo scenes/*.toml)
learn() { "$program" learn "$scene" --labels 20000 "$@" >/dev/null; }
world() {
    printf '{"world": {"collision_objects": [{"header": {"frame_id": "w"}, "id": "tray", "meshes": [{"vertices":
      [{"x": 0, "y": 0, "z": 0}, {"x": 1, "y": 0, "z": 0}, {"x": 0, "y": 1, "z": 0}, {"x": 0, "y": 0, "z": %s}],
      "triangles": [{"vertex_indices": [0, 2, 1]}, {"vertex_indices": [0, 1, 3]}, {"vertex_indices": [1, 2, 3]},
      {"vertex_indices": [2, 0, 3]}]}], "mesh_poses": [{"position": {"x": 1, "y": 0, "z": 0},
      "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}]}]}}' "$1" >world.json
}

# Existing files, which the commands replace.
learn -o full/a.model --seed 1 2>/dev/null
world 1
"$program" import world.json -o full/world.toml >/dev/null
world 2
"$program" demo --scene planar-arm --queries 1 --seconds 0.1 --out full/demo.html >/dev/null 2>&1
"$program" plan "$scene" --from 1.9,0,0 --to -1.9,0,0 --roadmap full/kept >/dev/null 2>&1
"$program" view "$scene" -n 1 -o full/view.html >/dev/null
"$program" report full/a.model -n 2 -o full/report.html >/dev/null
"$program" man full/man
"$program" demo --scene hand --export hand >/dev/null
printf '\n[[obstacle]]\nname = "ball"\nshape = { sphere = 0.03 }\npose = { xyz = [0, 0, 0.08] }\n' >>hand/hand.toml
"$program" sample hand/hand.toml -n 40 --seed 1 >grasps.jsonl
grasp() { "$program" grasp hand/hand.toml --input "$1" --object ball -o full/grasps.jsonl "${@:2}"; }
head -n 1 grasps.jsonl >one.jsonl
grasp one.jsonl >/dev/null 2>&1 || true

# Fills the disk but for some bytes, runs a command there, and compares.
fails() {
    local room=$1 file=$2
    shift 2
    rm -f full/filling
    head -c 8m /dev/zero >full/filling 2>/dev/null || true
    truncate -s "-$room" full/filling
    local before
    before=$(find full -type f -exec sha256sum {} + | sort)
    if "$@" >told 2>&1; then
        echo "full disk: '$*' said that it was done, with room for $room bytes" >&2
        exit 1
    fi
    if ! grep -q "extricate: error: cannot write .*$file.*No space left on device" told; then
        echo "full disk: '$*' said:" >&2
        cat told >&2
        exit 1
    fi
    if [ "$before" != "$(find full -type f -exec sha256sum {} + | sort)" ]; then
        echo "full disk: '$*' changed files:" >&2
        diff <(echo "$before") <(find full -type f -exec sha256sum {} + | sort) >&2
        exit 1
    fi
    checked=$((checked + 1))
}

checked=0
# No space, and space for a part; a page is the smallest unit of a tmpfs.
for room in 0 4096 8192; do
    fails "$room" full/a.model "$program" learn "$scene" -o full/a.model --labels 20000
    fails "$room" full/new.model "$program" learn "$scene" -o full/new.model --labels 20000
    fails "$room" full/there "$program" demo --scene shelf-arm --export full/there
done
fails 0 full/world-meshes/tray.obj "$program" import world.json -o full/world.toml
# Space for the mesh alone: the old one stays, since it belongs to the old scene.
fails 4096 full/world.toml "$program" import world.json -o full/world.toml
fails 0 full/kept "$program" plan "$scene" --from 1.9,0,0 --to -1.9,0,0.1 --roadmap full/kept
fails 0 full/view.html "$program" view "$scene" -n 1 -o full/view.html
fails 4096 full/view.html "$program" view "$scene" -n 1 -o full/view.html
fails 0 full/report.html "$program" report full/a.model -n 2 -o full/report.html
fails 0 full/man/extricate "$program" man full/man
fails 4096 full/man/extricate "$program" man full/man
fails 0 full/grasps.jsonl.part grasp grasps.jsonl
fails 0 full/demo.html "$program" demo --scene planar-arm --queries 1 --seconds 0.1 --out full/demo.html

# Grasps that fit stay beside the old file, for --resume.
before=$(sha256sum full/grasps.jsonl)
truncate -s -4096 full/filling
if grasp grasps.jsonl >told 2>&1; then exit 1; fi
grep -q "cannot write full/grasps.jsonl.part: No space left on device" told || { cat told >&2; exit 1; }
[ -s full/grasps.jsonl.part ] && [ "$before" = "$(sha256sum full/grasps.jsonl)" ]
checked=$((checked + 1))

# With enough space again, all commands succeed.
rm full/filling
grasp grasps.jsonl --resume >/dev/null 2>&1 || true
[ "$(wc -l <full/grasps.jsonl)" = 40 ] && [ ! -e full/grasps.jsonl.part ]
"$program" import world.json -o full/world.toml >/dev/null
"$program" info full/a.model >/dev/null
if find full -name '.extricate-*' | grep .; then exit 1; fi
echo "full disk: $checked commands ended rightly"
