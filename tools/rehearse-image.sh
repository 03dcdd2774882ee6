#!/usr/bin/env bash
# Builds the container image and runs it the way a careful host would, without Docker: on Debian, as root.
# The base is a minimal Debian 12 (Python 3.11) made here in place of the Dockerfile's default, so no registry is asked.
set -euo pipefail
cd "$(dirname "$0")/.."

suite=bookworm
image=localhost/vibroscope
work=${REHEARSAL_DIR:-/var/tmp/vibroscope-rehearsal} # the base is kept here for the next time
container='' server=''

say() { printf '%6ss  %s\n' "$SECONDS" "$*"; }
fail() { say "FAILED: $*"; exit 1; }
# A store of its own: whatever images this machine has stay as they are.
store() { command buildah --root "$work/store" --runroot "$work/run" --storage-driver vfs "$@"; }

clean_up() {
    [ -z "$server" ] || kill -KILL "$server" 2>/dev/null || true
    [ -z "$container" ] || store rm "$container" >/dev/null || true
    store rmi --prune >/dev/null 2>&1 || true # what the new image replaced
}
trap clean_up EXIT

# --- tools and base -------------------------------------------------------------------------------------------------

[ "$(id -u)" = 0 ] || fail "this needs root"
missing=''
for tool in debootstrap buildah ip:iproute2; do
    command -v "${tool%:*}" >/dev/null || missing+=" ${tool#*:}"
done
if [ -n "$missing" ]; then
    apt-get update --quiet
    # shellcheck disable=SC2086
    apt-get install --quiet --yes --no-install-recommends $missing
fi

mkdir -p "$work"
if ! store inspect --type image "$image-base" >/dev/null 2>&1; then
    say "making the base: Debian $suite"
    rm -rf "$work/base"
    debootstrap --variant=minbase --include=python3,python3-venv,ca-certificates "$suite" "$work/base" >"$work/debootstrap.log"
    container=$(store from scratch)
    # as published bases are: without the packages it was made of, manuals and translations
    rm -rf "$work"/base/var/cache/apt/* "$work"/base/var/lib/apt/lists/* "$work"/base/usr/share/{doc,man,locale}/*
    store add --quiet "$container" "$work/base" / >/dev/null
    store commit --quiet "$container" "$image-base" >/dev/null
    store rm "$container" >/dev/null
    container=''
    rm -rf "$work/base"
fi

# --- build ----------------------------------------------------------------------------------------------------------

# pip's settings and the certificates of this machine are lent to the build and do not stay in the image.
lent=(--volume /etc/ssl/certs:/etc/ssl/certs:ro)
[ ! -e /etc/pip.conf ] || lent+=(--volume /etc/pip.conf:/etc/pip.conf:ro)
say "building"
store build --isolation chroot --format docker --pull-never --build-arg BASE="$image-base" "${lent[@]}" \
    --tag "$image" . >"$work/build.log" 2>&1 || { tail -n 30 "$work/build.log"; fail "build, see $work/build.log"; }
say "built"

# --- run ------------------------------------------------------------------------------------------------------------

# setting NAME: one entry a line of what the image says about itself
setting() { store inspect --type image --format "{{range .Docker.Config.$1}}{{println .}}{{end}}" "$image" | sed '/^$/d'; }
mapfile -t environment < <(setting Env)
mapfile -t entry < <(setting Entrypoint; setting Cmd)
mapfile -t health < <(setting Healthcheck.Test | tail -n +2)
user=$(store inspect --type image --format '{{.Docker.Config.User}}' "$image")
stop=$(store inspect --type image --format '{{.Docker.Config.StopSignal}}' "$image")
stop=${stop:-SIGTERM}
uid=${user%:*} gid=${user#*:}

container=$(store from "$image")
root=$(store mount "$container")
size=$(du -sm "$root" | cut -f1)
[ "$size" -lt 600 ] || fail "the image has $size MB: less than 600 is meant"
say "image: $size MB, of it libraries $(du -sm "$root/opt/vibroscope/.venv" | cut -f1) MB and kernels $(du -sk "$root/opt/vibroscope/cache" | cut -f1) kB"

# Own network (nothing outside to lean on), own processes, read-only but for /tmp, another user, no capabilities.
started=$(date +%s%N)
# shellcheck disable=SC2016
unshare --mount --net --pid --fork --kill-child bash -euc '
    root=$1 uid=$2 gid=$3; shift 3
    mount --bind "$root" "$root"
    mount -t proc proc "$root/proc"
    mount -t tmpfs -o mode=1777 tmp "$root/tmp"
    mount -t tmpfs dev "$root/dev"
    for device in null zero urandom; do touch "$root/dev/$device"; mount --bind "/dev/$device" "$root/dev/$device"; done
    mount -o remount,bind,ro "$root"
    ip link set lo up
    exec chroot "$root" setpriv --reuid "$uid" --regid "$gid" --clear-groups --bounding-set=-all --inh-caps=-all \
        --no-new-privs env --ignore-environment --chdir /opt/vibroscope "$@"
' rehearsal "$root" "$uid" "$gid" "${environment[@]}" "${entry[@]}" >"$work/server.log" 2>&1 &
outer=$!
sleep 0.1
server=$(pgrep --parent "$outer") || { cat "$work/server.log"; fail "start"; }

inside() {
    nsenter --target "$server" --mount --net --pid --root --wd --setuid "$uid" --setgid "$gid" \
        env --ignore-environment "${environment[@]}" "$@"
}
until inside "${health[@]}" 2>"$work/health.log"; do
    kill -0 "$server" 2>/dev/null || { cat "$work/server.log"; fail "the server ended"; }
    [ $(($(date +%s%N) - started)) -lt 60000000000 ] || { cat "$work/server.log" "$work/health.log"; fail "never healthy"; }
    sleep 0.1
done
say "healthy after $((($(date +%s%N) - started) / 1000000)) ms"

status() { sed -n "s/^$1:\t *//p" "/proc/$server/status"; }
say "user $(status Uid | cut -f1), capabilities $(status CapEff), no new privileges $(status NoNewPrivs), memory $(status VmRSS)"
[ "$(status Uid | cut -f1)" = "$uid" ] && [ "$(status CapEff)" = 0000000000000000 ] && [ "$(status CapBnd)" = 0000000000000000 ] \
    && [ "$(status NoNewPrivs)" = 1 ] || fail "more rights than meant"
inside sh -c '! touch /opt/vibroscope/x 2>/dev/null' || fail "the image can be written to"
# tools/trim-image took files out: whatever the page names must be there.
named='
import sys
from html.parser import HTMLParser
from urllib.parse import urljoin
from urllib.request import urlopen
site, found = sys.argv[1], set()
class Page(HTMLParser):
    def handle_starttag(self, tag, attributes):
        found.update(value for name, value in attributes if name in ("src", "href") and value)
Page().feed(urlopen(site, timeout=60).read().decode())
files = {urljoin(site, name).partition("#")[0] for name in found if not name.startswith("data:")}
assert any(".js" in name for name in files), files
for name in sorted(files):
    assert name.startswith(site), name
    try:
        assert urlopen(name, timeout=60).status == 200, name
    except OSError as error:  # 404 and its like
        sys.exit(f"{name}: {error}")
print(len(files))
'
count=$(inside python3 -c "$named" http://127.0.0.1:5006/) || { cat "$work/server.log"; fail "the page or a file that it names"; }
say "page served, and $count files that it names"

documented='
import sys
from urllib.request import urlopen
from vibroscope.app.server.security import HEADERS
site = sys.argv[1]
for name in ("docs/", "docs/start.html", "docs/_static/site.css"):
    answer = urlopen(site + name, timeout=60)
    assert answer.status == 200, name
    for header in HEADERS:
        assert len(answer.headers.get_all(header, [])) == 1, (name, header)
assert b"Vibroscope" in urlopen(site + "docs/").read()
'
inside "${entry[0]}" python3 -c "$documented" http://127.0.0.1:5006/ || { cat "$work/server.log"; fail "the documentation"; }
say "documentation under /docs, with the headers of the page"

offered='
import io
import re
import sys
import zipfile
from urllib.request import urlopen
folder = sys.argv[1] + "docs/wheel/"
name = re.search(r"href=\"(vibroscope-[^\"]*\.whl)\"", urlopen(folder, timeout=60).read().decode())[1]
held = zipfile.ZipFile(io.BytesIO(urlopen(folder + name, timeout=60).read()))
assert held.testzip() is None
assert "vibroscope/assets/site/index.html" in held.namelist()
print(name)
'
wheel=$(inside python3 -c "$offered" http://127.0.0.1:5006/) || { cat "$work/server.log"; fail "the wheel"; }
say "$wheel under /docs/wheel/"

scene=(vibroscope simulate --solver newmark --eta 2.76 --K 12000 --D 18 --steps 2000 --json)
inside "${entry[0]}" "${scene[@]}" | inside python3 -c 'import json, sys; assert json.load(sys.stdin)["status"] == "ok"' \
    || fail "${scene[*]}"
say "a scene solved inside"
if [ -x .venv/bin/python ]; then # the client of the tests, from outside, in the network of the container
    nsenter --target "$server" --net .venv/bin/python tests/release/hold_sessions.py http://localhost:5006 \
        || { cat "$work/server.log"; fail "no session"; }
    say "three sessions: page, websocket, a value set"
else
    say "NOT TRIED: sessions, since there is no .venv here to open them from (make test sets it up)"
fi

# The machine code must be found again, for either CPU.
compiled='
import gc
from numba.core.dispatcher import Dispatcher
from vibroscope.app.commands.cli import main
main(["warm"])
stats = [found.stats for found in gc.get_objects() if isinstance(found, Dispatcher)]
assert sum(sum(each.cache_hits.values()) for each in stats) > 0
print(sum(sum(each.cache_misses.values()) for each in stats))
'
for cpu in '' generic; do
    count=$(inside env NUMBA_CPU_NAME="$cpu" "${entry[0]}" python3 -c "$compiled")
    [ "$count" = 0 ] || fail "$count kernels compiled at start, CPU '${cpu:-chosen here}'"
done
say "kernels found, none compiled"

stopped=$(date +%s%N)
kill -s "${stop#SIG}" "$server"
for _ in $(seq 100); do kill -0 "$server" 2>/dev/null || break; sleep 0.1; done
kill -0 "$server" 2>/dev/null && fail "does not stop when told to"
server=''
code=0; wait "$outer" || code=$?
say "stopped after $((($(date +%s%N) - stopped) / 1000000)) ms, exit code $code"
[ "$code" = 0 ] || { tail -n 20 "$work/server.log"; fail "exit code $code"; }
say "the image works"
