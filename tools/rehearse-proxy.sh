#!/usr/bin/env bash
# Runs deploy/nginx.conf for real, on this machine alone, in front of two replicas, and tries what it promises: the page,
# its websocket, stickiness, headers, rate limits, a replica that ends. Needs nginx (Debian: apt install nginx-light).
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
# ports: of the proxy and of the two replicas
read -r port first second < <(.venv/bin/python -c 'if 1:
    import socket
    probes = [socket.create_server(("127.0.0.1", 0)) for _ in range(3)]
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

# The committed configuration with nothing changed but the port; only the list of replicas is another one.
sed "s/listen 8080/listen 127.0.0.1:$port/; s|include upstream.conf|include $work/upstream.conf|" deploy/nginx.conf >"$work/site.conf"
printf 'server 127.0.0.1:%s max_fails=2 fail_timeout=10s;\n' "${replicas[@]}" >"$work/upstream.conf"
cat >"$work/nginx.conf" <<END
pid $work/nginx.pid;
error_log $work/error.log warn;
events {}
http {
    include /etc/nginx/mime.types;
    access_log $work/access.log;
    client_body_temp_path $work/body; proxy_temp_path $work/proxy; fastcgi_temp_path $work/f; uwsgi_temp_path $work/u; scgi_temp_path $work/s;
    include $work/site.conf;
}
END
nginx -t -q -c "$work/nginx.conf" || fail "configuration"
say "nginx -t: the configuration is good"

BOKEH_SECRET_KEY=$(.venv/bin/python -c 'import secrets; print(secrets.token_urlsafe(48))')
export BOKEH_SECRET_KEY VIBROSCOPE_ORIGINS=127.0.0.1:$port VIBROSCOPE_PROXIED=yes
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

curl -s -o /dev/null --interface 127.0.0.2 -H 'X-Real-Ip: 192.0.2.1' -H 'Sec-WebSocket-Protocol: bokeh, forged' "$site/ws"
grep -hq 'what=token address=127.0.0.2' "$work"/app?.log || fail "the log does not name the client"
say "the log names the client's address, not the proxy's, nor what a client says of itself"

headers=$(curl -sI "$site/")
for name in Content-Security-Policy X-Content-Type-Options Referrer-Policy Permissions-Policy; do
    grep -qi "^$name:" <<<"$headers" || fail "no $name"
done
! grep -Eqi '^server: .*/[0-9]' <<<"$headers" || fail "the server tells its version"
say "security headers pass"
for path in /metrics /liveness /autoload.js /components/os/x/y/z; do
    [ "$(curl -s -o /dev/null -w '%{http_code}' "$site$path")" = 404 ] || fail "$path answers"
done
say "metrics and liveness are not for outside"

refused=$(curl -s -o /dev/null -w '%{http_code}\n' "$site/?x=[1-300]" | grep -c 429 || true)
[ "$refused" -ge 100 ] || fail "rate limit: $refused of 300 refused"
say "rate limit: $refused of 300 pages in a row answered 429"
[ "$(head -c 5000 /dev/zero | curl -s -o /dev/null -w '%{http_code}' --data-binary @- "$site/static/x")" = 413 ] || fail "upload"
say "uploads refused: 413"

busy=$(grep -l 'session opened' "$work"/app?.log | sed 's/.*app\(.\).log/\1/')
kill "${running[$((busy - 1))]}"; wait "${running[$((busy - 1))]}" || fail "replica ended with $?"
sleep 12
.venv/bin/python tests/release/hold_sessions.py "$site" 1 || fail "the other replica does not take over"
say "the replica that held the session ended with 0; the other one takes over"
