"""A server that is killed, and one that is asked to stop while every session moves."""

import signal

from tests.browserless import Client, mapped, move, token_of
from tests.release.odd import run
from tests.served import served


def test_a_session_of_a_killed_server_continues_on_another(tmp_path, report):
    """With the browser's token and address, if both servers sign with the same key."""
    query, signing = "eta=1.3&view=explore", {"BOKEH_SECRET_KEY": "k" * 48}

    async def moved(server, token, number, eta):
        client = await Client(server.url, query).open(token=token)
        await client.ready()
        begun = await client.shown(lambda shown: shown.get("texts"))
        moved = await client.set(number, eta=eta)
        return client, begun["texts"]["eta"], moved["texts"]["eta"]

    async def one_after_the_other():
        with served(tmp_path / "first.txt", **signing) as first:
            token = await token_of(f"{first.url}/?{query}")
            client, *shown = await moved(first, token, 1, "1.4")
            assert shown == ["1.3", "1.4"]
            first.process.kill()
            first.process.wait()
            while await client.receive() is not None:
                pass  # what was under way, until the connection is closed
            client.socket.close()
        with served(tmp_path / "second.txt", **signing) as second:
            client, *shown = await moved(second, token, 1, "1.5")
            assert shown == ["1.3", "1.5"]
            client.socket.close()

    run(one_after_the_other(), 400)
    assert "Traceback" not in (tmp_path / "second.txt").read_text()
    report("a server killed: its session continues on another one, same token, same address", faults=1, sessions=1)


def test_a_stop_under_load_answers_every_move(tmp_path, report):
    with served(tmp_path / "log.txt") as server:

        async def load():
            clients = [await Client(server.url).open() for _ in range(8)]
            for client in clients:
                await client.ready()
                shown = await client.shown(lambda shown: shown.get("update"))
                await client.patch(client.message(mapped({"painted": shown["update"]})))
            for number, client in enumerate(clients):
                await client.patch(client.message(move({"eta": f"1.{30 + number}", "steps": "32000"}, 5)))
            server.process.send_signal(signal.SIGTERM)
            answers = [await client.shown(lambda shown: shown.get("move") == 5) for client in clients]
            for client in clients:
                client.socket.close()
            return [answer["texts"]["eta"] for answer in answers]

        assert run(load(), 400) == [f"1.{30 + number}".rstrip("0") for number in range(8)]
        assert server.stop() == 0
    assert "Traceback" not in (tmp_path / "log.txt").read_text()
    report("SIGTERM with 8 moves under way: 8 answered, exit status 0", faults=1, sessions=8)
