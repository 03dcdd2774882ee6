#!/usr/bin/env bash
# Runs deploy/main.conf and deploy/nginx.conf for real, on this machine alone, in front of two replicas, and tries what
# they promise: page and websocket, stickiness, headers, rate limits, silent connections, a replica that ends, and HTTPS.
# Needs nginx and curl, for HTTPS openssl (Debian: apt install nginx-light curl openssl).
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
# ports: of the proxy, of the two replicas, and with HTTPS of the proxy and of what leads there
read -r port first second tls plain < <(.venv/bin/python -c 'if 1:
    import socket
    probes = [socket.create_server(("127.0.0.1", 0)) for _ in range(5)]
    print(*(probe.getsockname()[1] for probe in probes))')
replicas=("$first" "$second")
site=http://127.0.0.1:$port
running=()

say() { printf '%6ss  %s\n' "$SECONDS" "$*"; }
fail() { say "FAILED: $*"; tail -n 5 "$work"/*.log; exit 1; }
clean_up() {
    [ ! -e "$work/nginx.pid" ] || kill "$(cat "$work/nginx.pid")" 2>/dev/null || true
    [ ${#running[@]} = 0 ] || kill "${running[@]}" 2>/dev/null || true
    wait
    rm -rf "$work"
}
trap clean_up EXIT
for tool in nginx curl; do command -v "$tool" >/dev/null || { say "needs $tool"; exit 1; }; done

# The committed configuration: other ports, other folders, other replicas, and one worker as where there is one core.
here="s/listen 8080/listen 127.0.0.1:$port/; s|include upstream.conf|include $work/upstream.conf|"
sed "$here" deploy/nginx.conf >"$work/site.conf"
printf 'server 127.0.0.1:%s max_fails=2 fail_timeout=10s;\n' "${replicas[@]}" >"$work/upstream.conf"
folders=''
for name in client_body proxy fastcgi uwsgi scgi; do folders+="${name}_temp_path $work/$name; "; done
sed "s|^user .*||; s|auto;|1;|; s|/var/log/nginx|$work|; s|/var/run|$work|; s|include /etc/nginx/conf.d.*|$folders include $work/site.conf;|" \
    deploy/main.conf >"$work/nginx.conf"
nginx -t -q -c "$work/nginx.conf" || fail "configuration"
say "nginx -t: the configuration is good"

BOKEH_SECRET_KEY=$(.venv/bin/python -c 'import secrets; print(secrets.token_urlsafe(48))')
export BOKEH_SECRET_KEY VIBROSCOPE_ORIGINS=127.0.0.1:$port,127.0.0.1:$tls,example.org VIBROSCOPE_PROXIED=yes
for number in 1 2; do
    .venv/bin/vibroscope serve --port "${replicas[number - 1]}" >"$work/app$number.log" 2>&1 &
    running+=($!)
done
for number in 1 2; do
    for _ in $(seq 300); do curl -sf "http://127.0.0.1:${replicas[number - 1]}/liveness" >/dev/null && break; sleep 0.2; done
done
nginx -c "$work/nginx.conf"
say "proxy and two replicas up"

.venv/bin/python tests/release/hold_sessions.py "$site" 40 || fail "sessions"
opened() { cat "$work"/app?.log | grep -c 'session opened' || true; }
held=$(for n in 1 2; do grep -c 'session opened' "$work/app$n.log" || true; done | grep -vc '^0$')
[ "$held" = 1 ] || fail "$(opened) sessions on $held replicas: not sticky"
say "40 sessions of one address at once: page, websocket, a value set, all in the same replica"

curl -s -o /dev/null --interface 127.0.0.2 -H "Origin: $site" -H 'X-Real-Ip: 192.0.2.1' -H 'Sec-WebSocket-Protocol: bokeh, forged' "$site/ws"
grep -hq 'what=token address=127.0.0.2' "$work"/app?.log || fail "the log does not name the client"
say "the log names the client's address, not the proxy's, nor what a client says of itself"

# Each sends the beginning of a header and no more, so that no limit by address counts it.
silent() {
    .venv/bin/python - "$port" <<'END'
import resource, socket, subprocess, sys, time
COUNT, port = 1500, int(sys.argv[1])
most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
if most != resource.RLIM_INFINITY and most < 2 * COUNT:
    sys.exit(f"NOT TRIED: {COUNT} silent connections, since a process may have {most} files open here")
resource.setrlimit(resource.RLIMIT_NOFILE, (2 * COUNT, most))
held = []
for _ in range(COUNT):
    held.append(socket.create_connection(("127.0.0.1", port), 10))
    held[-1].sendall(b"GET / HTTP/1.1\r\nHost: x")
begun = time.monotonic()
page = ["curl", "-sf", "-m", "4", "--interface", "127.0.0.3", "-o", "/dev/null", f"http://127.0.0.1:{port}/"]
assert subprocess.run(page).returncode == 0, "no page"
taken = 1000 * (time.monotonic() - begun)
for each in held:
    each.settimeout(10)
    while each.recv(1000):
        pass
print(f"{COUNT} silent connections: a page after {taken:.0f} ms, all of them closed after {time.monotonic() - begun:.0f} s")
END
}
report=$(silent 2>"$work/silent.log") || grep -q '^NOT TRIED' "$work/silent.log" || fail "silent connections"
say "${report:-$(cat "$work/silent.log")}"

# headers STATUS [curl's options] ADDRESS: the (last) answer must have this status, and each header once
headers() {
    local status=$1 answer name; shift
    answer=$(curl -s -o /dev/null -D - "$@" | awk 'BEGIN { RS = "\r\n\r\n" } NF { last = $0 } END { print last }')
    grep -q "^HTTP/1.1 $status" <<<"$answer" || fail "not $status: $*: $answer"
    for name in "${security[@]}"; do
        [ "$(grep -ci "^$name:" <<<"$answer")" = 1 ] || fail "$status: $name not once: $answer"
    done
    ! grep -Eqi '^server: .*/[0-9]' <<<"$answer" || fail "$status: the server shows its version"
}
mapfile -t security < <(.venv/bin/python -c 'if 1:
    from vibroscope.app.server.security import HEADERS
    print(*HEADERS, sep="\n")')
headers 200 "$site/"
headers 404 "$site/nothing"
headers 400 -H 'Host: a b' "$site/"
headers 413 --data-binary "$(head -c 5000 /dev/zero | tr '\0' x)" "$site/static/x"
headers 400 -H 'Content-Length: x' "http://127.0.0.1:$first/"
headers 404 "$site/docs/no"
if [ -f assets/site/index.html ]; then
    headers 301 "$site/docs"
    headers 200 -L "$site/docs"
    # one of each kind of file that its first page names
    for kind in css js; do
        file=$(curl -s "$site/docs/" | grep -o "_static/[^\"? ]*\.$kind" | head -n 1)
        headers 200 "$site/docs/$file"
    done
    say "the documentation under /docs, with the same headers"
else
    curl -s "$site/docs/" | grep -q 'make docs' || fail "/docs/ does not say how to build the documentation"
    say "NOT TRIED: the documentation, which is not built here (make docs); /docs says so"
fi
say "security headers, each once: the page, nginx's own 404, 400 and 413, and a bare 400 of Tornado"

# knocks SITE HOST: who may come in under this name, by page and by websocket, and who may not
knocks() {
    local site=$1 host=$2 origin; shift 2
    origin=${site%%:*}://$host
    token=$(curl -s "$@" -H "Host: $host" "$site/" | grep -o '"token":"[^"]*"' | cut -d '"' -f 4) || fail "no page for $host"
    local socket=("$@" -o /dev/null -w '%{http_code}' --max-time 2 -H 'Upgrade: websocket' -H 'Connection: Upgrade'
        -H 'Sec-WebSocket-Version: 13' -H 'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==' -H "Sec-WebSocket-Protocol: bokeh, $token")
    knock() { # STATUS HOST ORIGIN
        local got; got=$(curl -s --http1.1 "${socket[@]}" -H "Host: $2" -H "Origin: $3" -H 'Sec-Fetch-Site: same-origin' "$site/ws") || true
        [ "$got" = "$1" ] || fail "$site, Host $2, Origin $3: $got, not $1"
    }
    knock 421 evil.example "${site%%:*}://evil.example"
    knock 421 evil.example "$origin"
    knock 421 "$host.evil.example" "$origin"
    knock 403 "$host" "${site%%:*}://evil.example"
    knock 403 "$host" "${origin%:*}:1"
    knock 403 "$host" null
    knock 101 "$host" "$origin"
    headers 421 "$@" -H 'Host: evil.example' "$site/"
}
knocks "$site" "127.0.0.1:$port"
say "a page and a websocket only for the server's own name, whatever Host, Origin and Sec-Fetch-Site say"
for path in /metrics /liveness /autoload.js /components/os/x/y/z; do
    [ "$(curl -s -o /dev/null -w '%{http_code}' "$site$path")" = 404 ] || fail "$path answers"
done
say "metrics and liveness are not for outside"

refused=$(curl -s -o /dev/null -w '%{http_code}\n' "$site/?x=[1-300]" | grep -c 429 || true)
[ "$refused" -ge 100 ] || fail "rate limit: $refused of 300 refused"
say "rate limit: $refused of 300 pages in a row answered 429"
headers 429 "$site/?x=[1-100]"
say "and nginx's 429"

busy=$(grep -l 'session opened' "$work"/app?.log | sed 's/.*app\(.\).log/\1/')
kill "${running[$((busy - 1))]}"; wait "${running[$((busy - 1))]}" || fail "replica ended with $?"
sleep 12
.venv/bin/python tests/release/hold_sessions.py "$site" 1 || fail "the other replica does not take over"
say "the replica that held the session ended with 0; the other one takes over"

# --- HTTPS: the lines marked so, taken in, with a certificate of its own ----------------------------------------------

if ! command -v openssl >/dev/null; then
    say "NOT TRIED: HTTPS, which needs openssl"
else
    marked() { sed -E 's/^( *)# (.*[^ ]) *# HTTPS$/\1\2/' "$1"; } # with those lines taken in
    for line in 443:8443 80:8081 ./tls:/etc/nginx/tls:ro; do
        marked compose.yaml | grep -Eq "^ +- $line *$" || fail "compose.yaml, taken in, has no $line"
    done
    mkdir "$work/tls"
    openssl req -x509 -newkey rsa:2048 -nodes -days 1 -subj /CN=rehearsal -addext subjectAltName=IP:127.0.0.1 \
        -keyout "$work/tls/privkey.pem" -out "$work/tls/fullchain.pem" 2>"$work/openssl.log" || fail "openssl"
    marked deploy/nginx.conf | sed "$here; s/listen 8443/listen 127.0.0.1:$tls/; s/listen 8081/listen 127.0.0.1:$plain/; s|/etc/nginx/tls|$work/tls|" \
        >"$work/site.conf"
    nginx -t -q -c "$work/nginx.conf" || fail "configuration with HTTPS"
    nginx -s reload -c "$work/nginx.conf" 2>>"$work/openssl.log"
    export SSL_CERT_FILE=$work/tls/fullchain.pem CURL_CA_BUNDLE=$work/tls/fullchain.pem
    for _ in $(seq 50); do curl -sf -o /dev/null --interface 127.0.0.4 "https://127.0.0.1:$tls/favicon.ico" && break; sleep 0.1; done
    security+=(Strict-Transport-Security)
    headers 200 --interface 127.0.0.4 "https://127.0.0.1:$tls/"
    headers 404 --interface 127.0.0.4 "https://127.0.0.1:$tls/nothing"
    knocks "https://127.0.0.1:$tls" "127.0.0.1:$tls" --interface 127.0.0.4
    knocks "https://127.0.0.1:$tls" example.org --interface 127.0.0.4 # as on port 443
    unset 'security[-1]' # a browser takes it over HTTPS only
    .venv/bin/python tests/release/hold_sessions.py "https://127.0.0.1:$tls" 1 || fail "no session over HTTPS"
    led=$(curl -s -o /dev/null -w '%{http_code} %{redirect_url}' "http://127.0.0.1:$plain/?eta=1.2")
    [ "$led" = '301 https://127.0.0.1/?eta=1.2' ] || fail "plain HTTP answers $led"
    headers 301 "http://127.0.0.1:$plain/"
    say "HTTPS: page, websocket, a value set, no other name; plain HTTP leads there"
fi

# --- no replica left ---------------------------------------------------------------------------------------------------

kill "${running[$((2 - busy))]}"; wait "${running[$((2 - busy))]}" || fail "replica ended with $?"
headers 502 --interface 127.0.0.5 "$site/"
say "nginx's 502 has the security headers, too"
