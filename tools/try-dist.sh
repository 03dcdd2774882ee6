#!/usr/bin/env bash
# Installs the wheel of dist/ with the dependencies that it declares into an empty environment of each Python that is
# here, and uses it, first without extras and then with them: try-dist.sh [VERSION …], by default all that Numba takes from
# 3.11 on. A Python that is missing is NOT TRIED.
set -euo pipefail
cd "$(dirname "$0")/.."

versions=("$@")
[ $# -gt 0 ] || versions=(3.11 3.12 3.13 3.14 3.15)
wheels=(dist/vibroscope-*.whl)
[ -f "${wheels[0]}" ] && [ ${#wheels[@]} = 1 ] || { echo "dist/ must hold one wheel: make dist"; exit 1; }
wheel=$(realpath "${wheels[0]}")
number=${wheel##*/vibroscope-}
number=${number%%-*}
work=$(mktemp --directory)
server=''

say() { printf '%6ss  %s\n' "$SECONDS" "$*"; }
fail() { say "FAILED: $*"; exit 1; }
end_server() {
    [ -z "$server" ] || { kill "$server" 2>/dev/null && wait "$server" 2>/dev/null; } || true
    server=''
}
clean_up() { end_server; rm -rf "$work"; }
trap clean_up EXIT

# python_of VERSION: its interpreter, of the system or of pyenv; a command of pyenv may stand for a version that is not set
python_of() {
    local candidate
    for candidate in "/usr/bin/python$1" "$(command -v "python$1" || true)" "${PYENV_ROOT:-$HOME/.pyenv}/versions/$1."*/bin/python; do
        [ -x "$candidate" ] && "$candidate" -c 'import ensurepip, venv' 2>/dev/null && { echo "$candidate"; return; }
    done
    return 1
}

try_with() {
    trap end_server EXIT # of this subshell
    local version=$1 python=$2
    local folder=$work/$version
    local bin=$folder/venv/bin
    "$python" -m venv "$folder/venv"
    "$bin/python" -m pip --disable-pip-version-check install --quiet "$wheel" || fail "install with Python $version"
    "$bin/python" -m pip --disable-pip-version-check check || fail "dependencies with Python $version"
    say "Python $version: installed with $("$bin/python" -m pip list 2>/dev/null | grep -Ei '^(numba|numpy|panel|zarr) ' | tr -s ' ' | paste -sd, -)"
    # nothing of the working copy, and no kernels of another version
    mkdir "$folder/home"
    cd "$folder/home"
    export HOME=$folder/home VIBROSCOPE_CACHE_DIR=$folder/cache
    [[ "$("$bin/vibroscope" --version)" = *"$number"* ]] || fail "--version is not $number"
    local scene=(--eta 2.76 --K 12000 --D 18)
    "$bin/vibroscope" simulate --solver newmark "${scene[@]}" --steps 2000 --json >simulated.json || fail "simulate"
    "$bin/python" -c 'import json; assert json.load(open("simulated.json"))["status"] == "ok"' || fail "simulate"
    say "Python $version: a scene solved"
    "$bin/vibroscope" sweep step "${scene[@]}" --steps 500,1000 --transient 50 --sample 10 --out steps.zarr >/dev/null || fail "sweep"
    "$bin/vibroscope" sweep check steps.zarr >/dev/null || fail "sweep check"
    say "Python $version: a sweep"
    "$bin/vibroscope" stability >stability.txt || { grep -v passed stability.txt | tail; fail "stability"; }
    say "Python $version: $(tail -n 1 stability.txt)"
    served "$version" "$bin"
    for shell in bash zsh fish; do
        "$bin/vibroscope" completion "$shell" | grep -q vibroscope || fail "completion $shell"
    done
    say "Python $version: completion for bash, zsh and fish"
    extras "$version" "$bin"
    cd - >/dev/null
}

# extras VERSION BIN: what the extras add, installed and used
extras() {
    "$2/python" -m pip --disable-pip-version-check install --quiet "$wheel[fit,cluster,codes]" || fail "extras with Python $1"
    "$2/python" -m pip --disable-pip-version-check check || fail "dependencies of the extras with Python $1"
    "$2/vibroscope" measurement >measured.csv
    local scene=(--eta 2.76 --K 12000 --D 18 --steps 2000)
    "$2/vibroscope" compare "${scene[@]}" --measured measured.csv --fit restitution | grep -q restitution || fail "fit"
    # a file: the workers' processes read it again
    cat >cluster.py <<'PYTHON'
import subprocess
import sys

from distributed import LocalCluster

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        plane = "sweep plane --eta 2.76 --K 100:60000:4 --D 1:100:4 --steps 500 --transient 20 --sample 10".split()
        subprocess.run(
            [sys.argv[1], *plane, "--scheduler", cluster.scheduler_address, "--out", "plane.zarr"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
PYTHON
    "$2/python" cluster.py "$2/vibroscope" || fail "sweep on a cluster with Python $1"
    say "Python $1: the extras fit, cluster and codes: installed; a fit, and a plane on two Dask workers"
}

# served VERSION BIN: the explorer answers, with its documentation
served() {
    local port
    port=$("$2/python" -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
    "$2/vibroscope" serve --port "$port" >server.log 2>&1 &
    server=$!
    "$2/python" - "http://127.0.0.1:$port" <<'PYTHON' || { tail server.log; fail "serve"; }
import sys
import time
from urllib.error import URLError
from urllib.request import urlopen

site = sys.argv[1]
for _ in range(1200):
    try:
        urlopen(site + "/liveness", timeout=10)
        break
    except URLError:
        time.sleep(0.1)
for path in ("/", "/docs/", "/docs/start.html"):
    answer = urlopen(site + path, timeout=60)
    assert answer.status == 200 and b"Vibroscope" in answer.read(), path
PYTHON
    end_server
    say "Python $1: the explorer and /docs/ served"
}

tried=0
for version in "${versions[@]}"; do
    if python=$(python_of "$version"); then
        (try_with "$version" "$python")
        tried=$((tried + 1))
    else
        say "NOT TRIED: the wheel with Python $version, which is not here"
    fi
done
[ "$tried" -gt 0 ] || fail "no Python to try"
say "the wheel works with $tried Pythons"
