"""What others run the server with: the images, compose.yaml and the proxy's configuration fit the program."""

import re
from datetime import date, timedelta
from pathlib import Path

import pytest
import yaml
from vibroscope.app.runtime import settings
from vibroscope.app.server import connections, server
from vibroscope.app.server.security import HEADERS

from tools import images

ROOT = Path(__file__).parents[1]
PROXY = (ROOT / "deploy/nginx.conf").read_text()
KEY = "k" * 48


@pytest.fixture(scope="module")
def compose():
    return yaml.safe_load((ROOT / "compose.yaml").read_text())


@pytest.fixture(scope="module")
def replica(compose):
    """One of the replicas: all are alike."""
    replicas = [service for name, service in compose["services"].items() if name.startswith("app")]
    assert all(each == replicas[0] for each in replicas)
    return replicas[0]


@pytest.fixture(scope="module")
def chosen(replica):
    """The settings that it starts with."""
    given = {name: re.sub(r"\$\{\w+:-(.*)\}", r"\1", str(text)) for name, text in replica["environment"].items()}
    assert given.pop("BOKEH_SECRET_KEY").startswith("${BOKEH_SECRET_KEY:?")  # no start without one
    assert not settings.unknown_variables(given)
    return settings.from_environment({**given, "BOKEH_SECRET_KEY": KEY})


def seconds(text):
    return int(re.fullmatch(r"(\d+)s", text)[1])


def directive(name):
    """What the proxy's configuration says after a name, where it says it once."""
    (found,) = re.findall(rf"^ *{name} ([^;]*);", PROXY, re.MULTILINE)
    return found


# --- compose.yaml -----------------------------------------------------------------------------------------------------


def test_a_replica_has_room_for_what_it_is_allowed(replica, chosen):
    assert chosen.proxied == "yes"
    assert chosen.threads < replica["pids_limit"] / 10  # `test_threads` counts what a server with so many starts
    assert replica["mem_limit"] == "2g"
    assert replica["read_only"]
    assert replica["cap_drop"] == ["ALL"]
    assert replica["security_opt"] == ["no-new-privileges:true"]


def test_a_replica_that_stops_may_end_what_is_under_way(replica):
    assert seconds(replica["stop_grace_period"]) > server.FINISH_SECONDS + server.CANCEL_SECONDS


def test_replicas_share_the_studies_and_nothing_else(replica, compose):
    dockerfile = (ROOT / "Dockerfile").read_text()
    (folder,) = set(re.findall(r"VIBROSCOPE_CACHE_DIR=(\S+)", dockerfile))
    assert replica["volumes"] == [f"studies:{folder}/studies"]
    assert f"install --directory --owner=10001 --group=10001 {folder.rpartition('/')[2]}/studies" in dockerfile
    assert set(compose["volumes"]) == {"studies"}


def test_nobody_reaches_a_replica_but_the_proxy(replica, compose):
    assert replica["networks"] == ["inside"]
    assert compose["networks"]["inside"] == {"internal": True}
    assert "ports" not in replica
    proxy = compose["services"]["proxy"]
    assert proxy["ports"] == [f"127.0.0.1:8080:{directive('listen')}"]
    for volume in proxy["volumes"]:
        assert (ROOT / volume.split(":")[0]).is_file(), volume
        assert volume.endswith(":ro")


def test_the_proxy_knows_all_replicas_under_their_names(compose):
    upstream = (ROOT / "deploy/upstream.conf").read_text()
    named = re.findall(r"^server (\w+):(\d+) ", upstream, re.MULTILINE)
    port = str(settings.Settings().port)
    assert named == [(name, port) for name in compose["services"] if name != "proxy"]
    assert set(compose["services"]["proxy"]["depends_on"]) == {name for name, _ in named}


# --- the proxy --------------------------------------------------------------------------------------------------------


def test_the_proxy_lets_go_of_a_connection_before_the_application_does():
    limits = re.findall(r"^ *keepalive_timeout (\w+);", PROXY, re.MULTILINE)
    assert limits
    assert max(map(seconds, limits)) < connections.OPTIONS["idle_connection_timeout"]


def test_one_address_may_hold_a_class_but_not_a_whole_replica(chosen):
    held = int(re.search(r"limit_conn held (\d+);", PROXY)[1])
    assert 40 < held < chosen.sessions
    assert "One address, a class behind one router say, may hold 40 sessions" in (ROOT / "compose.yaml").read_text()


def test_what_nginx_answers_itself_has_the_headers_of_the_application():
    own = dict(re.findall(r"^add_header (\S+) +(\$own_\w+) +always;$", PROXY, re.MULTILINE))
    assert own.keys() == HEADERS.keys()
    assert PROXY.count("add_header") == len(own) + 1  # that for HTTPS; one in a server would hide them all
    for name, variable in own.items():
        upstream = f"$upstream_http_{name.lower().replace('-', '_')}"
        (value,) = re.findall(
            rf"^map {re.escape(upstream)} +{re.escape(variable)} +{{ '' (.*); default ''; }}$", PROXY, re.M
        )
        if name == "Content-Security-Policy":  # its pages load nothing
            assert value == "\"default-src 'none'; frame-ancestors 'none'\""
        else:
            assert value.strip('"') == HEADERS[name]


# --- images -----------------------------------------------------------------------------------------------------------


def test_every_image_that_others_make_is_checked(compose):
    foreign = {service["image"] for service in compose["services"].values() if "build" not in service}
    base = re.search(r"^ARG BASE=(\S+)$", (ROOT / "Dockerfile").read_text(), re.MULTILINE)[1]
    stages = re.findall(r"^FROM (\S+)(?: AS (\S+))?", (ROOT / "Dockerfile").read_text(), re.MULTILINE)
    assert {begun for begun, _ in stages} - {name for _, name in stages} == {"${BASE}"}
    found = {f"{each.tag}@{each.digest}".rstrip("@") for each in images.images()}
    assert found == foreign | {base}
    assert [problem for each in images.images() if (problem := each.unpinned())] == []


def test_the_proxy_is_of_a_stable_branch():
    (tag,) = (each.tag for each in images.images() if each.file == "compose.yaml")
    major, minor = map(int, re.match(r"nginx:(\d+)\.(\d+)", tag).groups())
    assert (major, minor) >= (1, 30)
    assert minor % 2 == 0  # odd ones are mainline: their faults are mended in the next one only


def test_an_image_that_ages_or_has_no_digest_is_named():
    today = date(2026, 11, 23)
    image = images.Image("compose.yaml", "a:1", "sha256:" + "0" * 64, today, today + timedelta(days=200))
    assert image.aged(today) == image.unpinned() == ""
    assert "looked up 61 days ago" in image.aged(today + timedelta(days=61))
    assert "take the next one" in image.aged(today + timedelta(days=201))
    for digest in ("", "sha256:0", "sha256:" + "g" * 64):
        assert "a:1 has no digest" in images.Image("x", "a:1", digest, today, today).unpinned()


def test_digests_are_written_where_the_images_are_named(tmp_path, monkeypatch):
    digests = {each.tag: "sha256:" + f"{number:064d}" for number, each in enumerate(images.images())}
    for file in images.FILES:
        (tmp_path / file).write_text((ROOT / file).read_text())
    monkeypatch.setattr(images, "digest_of", digests.__getitem__)
    for _ in range(2):  # again: an old digest is replaced
        images.pin(tmp_path)
        pinned = list(images.images(tmp_path))
        assert {each.tag: each.digest for each in pinned} == digests
        assert {each.looked_up for each in pinned} == {date.today()}
        assert not any(each.unpinned() for each in pinned)
