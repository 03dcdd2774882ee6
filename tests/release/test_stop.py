"""A server that is killed, and one that is asked to stop while everyone moves."""

import signal

from tests.browserless import Client, mapped, move
from tests.release.odd import run
from tests.served import served


def test_a_killed_server_is_replaced_and_a_stop_under_load_answers_all(tmp_path, tell):
    key = {"BOKEH_SECRET_KEY": "k" * 48}
    with served(tmp_path / "first.txt", **key) as server:
        server.process.kill()
        server.process.wait()
    with served(tmp_path / "second.txt", **key) as server:

        async def load():
            clients = [await Client(server.url).open() for _ in range(8)]
            for client in clients:
                await client.ready()
                shown = await client.shown(lambda told: told.get("frame"))
                await client.patch(client.message(mapped({"painted": shown["frame"]})))
            for number, client in enumerate(clients):
                await client.patch(client.message(move({"eta": f"1.{30 + number}", "steps": "32000"}, 5)))
            server.process.send_signal(signal.SIGTERM)
            answers = [await client.shown(lambda told: told.get("move") == 5) for client in clients]
            for client in clients:
                client.socket.close()
            return [answer["texts"]["eta"] for answer in answers]

        assert run(load(), 400) == [f"1.{30 + number}".rstrip("0") for number in range(8)]
        assert server.stop() == 0
    assert "Traceback" not in (tmp_path / "second.txt").read_text()
    tell("a killed server replaced; SIGTERM with 8 moves under way: 8 answered, exit status 0", faults=2, sessions=8)
