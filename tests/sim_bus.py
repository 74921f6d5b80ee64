"""Provides the simulated bus, with recording nodes and a listener, to tests in Python."""

from __future__ import annotations

from sim_binding import load

ffi, lib = load()


def make_frame(identifier: int, data: bytes, fd: bool = True):
    frame = ffi.new("can_frame_t *", {"id": identifier, "length": len(data), "fd": fd})
    ffi.memmove(frame.data, data, len(data))
    return frame


class Bus:
    """A bus with a listener, and with nodes that record the frames they receive."""

    def __init__(self, nodes: int):
        self.bus = ffi.gc(lib.bus_create(lib.CAN_PROFILE_FD), lib.bus_destroy)
        self.received = [[] for _ in range(nodes)]
        self.heard = []
        self.reaction = [None] * nodes
        self.handlers = []
        for node in range(nodes):
            assert lib.bus_attach(self.bus, self._handler(self.received[node], node), ffi.NULL) == node
        lib.bus_listen(self.bus, self._handler(self.heard, None), ffi.NULL)

    def _handler(self, record, node):
        def receive(_context, frame, end_ns):
            record.append((frame.id, bytes(frame.data[0 : frame.length]), end_ns, frame.timestamp_us))
            if node is not None and self.reaction[node] is not None:
                self.reaction[node](frame.id, end_ns)

        self.handlers.append(ffi.callback("bus_handler_t", receive))
        return self.handlers[-1]

    def send(self, node: int, identifier: int, data: bytes = b"", ready_ns: int = 0) -> bool:
        return lib.bus_send(self.bus, node, make_frame(identifier, data), ready_ns)

    def run_until(self, time_ns: int):
        lib.bus_run_until(self.bus, time_ns)

    @property
    def statistics(self):
        return lib.bus_statistics(self.bus)
