"""A bus for processes without CAN in the kernel: every packet of each client goes to all others. Usage: hub_relay.py PATH"""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
import sys

PACKET_BYTES = (16, 72)  # struct can_frame, struct canfd_frame


def serve(path: str) -> None:
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    listener.bind(path + ".new")
    listener.listen()
    os.rename(path + ".new", path)  # whoever sees the path can connect
    clients: list[socket.socket] = []
    with selectors.DefaultSelector() as selector:
        selector.register(listener, selectors.EVENT_READ)
        while True:
            for key, _ in selector.select():
                if key.fileobj is listener:
                    client, _ = listener.accept()
                    clients.append(client)
                    selector.register(client, selectors.EVENT_READ)
                    continue
                try:
                    packet = key.fileobj.recv(1 + max(PACKET_BYTES))
                except ConnectionError:
                    packet = b""
                if len(packet) not in PACKET_BYTES:
                    selector.unregister(key.fileobj)
                    clients.remove(key.fileobj)
                    key.fileobj.close()
                    continue
                for client in clients:
                    if client is not key.fileobj:
                        with contextlib.suppress(OSError):  # gone, or its queue is full: its own loss
                            client.send(packet, socket.MSG_DONTWAIT)


if __name__ == "__main__":
    serve(sys.argv[1])
