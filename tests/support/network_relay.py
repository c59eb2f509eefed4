#!/usr/bin/env python3
"""Stands between sites and their server on this machine and makes a worse network of it: TCP and UDP on a
port a site.

    python3 tests/support/network_relay.py --server 127.0.0.1:7480 --sites 2 \
        --network '{"one_way_ms": 25, "jitter": 0.2, "loss": 0.02}'

A site joins by the server's link with the relay's port in it. The conditions are those of `tandem simulate`:
site to site, so each leg, between a site and the server, gets half of the delay and its share of what is
lost.

  one_way_ms              delay site to site
  jitter                  share of the delay, uniform, plus and minus
  loss, duplicate         probability a datagram on the whole way
  reorder                 probability that a datagram is held back by one more delay, 1 ms at least
  blackouts               [{"at": 5, "for_s": 0.2, "site": 1, "burst": true}, ..]: what would arrive
                          meanwhile is lost, or with `burst` comes at once in the end; without `site`
                          (from 0) that of all
  steps                   [{"at": 5, "one_way_ms": 250}, ..]: any of the upper four, from then on
TCP loses nothing and keeps its order; it is delayed as datagrams are, and waits for the end of a blackout.
Times count from the relay's start in s.

Prints one line of JSON when it listens, {"ports": [..]}, and another in the end: counts a site and way, and
by how much it was late itself. It ends after --duration or, with --orders, with its standard input, each line
of which is an object as in `steps`, as in `blackouts` ({"blackout": {"for_s": 1}}; 0 ends one), without `at`,
or {"report": true}, for the counts so far.
"""
import argparse
import array
import collections
import gc
import heapq
import itertools
import json
import math
import os
import random
import select
import socket
import struct
import sys
import time

SO_TIMESTAMPNS = 35  # Linux; Python names it from 3.13 on
CHUNK = 64 * 1024
MOST_UNDER_WAY = 1 << 20  # bytes of a TCP direction, before no more are read
DATAGRAMS_A_ROUND = 64
CONDITIONS = {"one_way_ms": 0.0, "jitter": 0.0, "loss": 0.0, "duplicate": 0.0, "reorder": 0.0}


def of_a_leg(probability):
    """On each of two legs, that of both together is `probability`."""
    return 1.0 - math.sqrt(1.0 - probability)


class Leg:
    """One way between a site and the server: what happens to each datagram. The same seed, the same fates in
    order."""

    def __init__(self, conditions, seed):
        self.conditions = conditions
        self.random = random.Random(seed)
        self.dark_until, self.burst = 0.0, False
        self.kept = []  # what waits for the end of a blackout
        self.last_in_order = 0.0  # when TCP has arrived so far, s
        self.newest_sent = -1
        self.counts = collections.Counter()

    def delay(self):
        half = 0.5e-3 * self.conditions["one_way_ms"]
        return half * (1.0 + self.conditions["jitter"] * self.random.uniform(-1.0, 1.0))

    def chance(self, what):
        return self.random.random() < of_a_leg(self.conditions[what])

    def fates(self, now):
        """When a datagram that came at `now` is passed on: never, once or twice."""
        self.counts["datagrams"] += 1
        lost, twice = self.chance("loss"), self.chance("duplicate")
        delays = [self.delay() + (max(self.delay(), 1e-3) if self.chance("reorder") else 0.0)
                  for _ in range(1 + twice)]
        if lost:
            self.counts["lost"] += 1
            return []
        self.counts["duplicated"] += twice
        return [now + delay for delay in delays]

    def in_order(self, now):
        """When bytes of TCP that came at `now` are passed on."""
        self.last_in_order = max(self.last_in_order, now + self.delay())
        return self.last_in_order

    def lift(self, now):
        """Ends a blackout if its time has come."""
        if now < self.dark_until:
            return
        kept, self.kept = self.kept, []
        for deliver in kept:
            deliver(now)

    def passed(self, number):
        self.counts["passed"] += 1
        self.counts["overtaken"] += number < self.newest_sent
        self.newest_sent = max(self.newest_sent, number)


class Datagrams:
    """Of one site: a socket here, and one towards the server for each address that the site has."""

    def __init__(self, relay, own, up, down):
        self.relay, self.own, self.up, self.down = relay, own, up, down
        self.towards_server, self.numbers = {}, itertools.count()
        relay.watch(own, self.from_site)

    def from_site(self):
        for data, arrived, address in received(self.own):
            sink = self.towards_server.get(address) or self.connect(address)
            self.send(self.up, arrived, sink.send, data)

    def connect(self, address):
        sink = datagram_socket()
        sink.connect(self.relay.server)
        self.towards_server[address] = sink

        def from_server():
            for data, arrived, _ in received(sink):
                self.send(self.down, arrived, lambda bytes_: self.own.sendto(bytes_, address), data)

        self.relay.watch(sink, from_server)
        return sink

    def send(self, leg, arrived, give, data):
        number = next(self.numbers)

        def deliver(now):
            if now < leg.dark_until:
                leg.counts["blacked_out"] += 1
                if leg.burst:
                    leg.kept.append(deliver)
                return
            try:
                give(data)
                leg.passed(number)
            except (BlockingIOError, ConnectionRefusedError):
                leg.counts["refused"] += 1  # nobody is there, or a full buffer

        for due in leg.fates(arrived):
            self.relay.at(due, deliver, timed=True)


class Stream:
    """One way of a TCP connection."""

    def __init__(self, connection, source, sink, leg):
        self.connection, self.source, self.sink, self.leg = connection, source, sink, leg
        self.relay = connection.relay
        self.under_way = collections.deque()  # (due, bytes); no bytes: the end
        self.size, self.ended = 0, False
        self.relay.watch(source, self.read)

    def read(self):
        try:
            data = self.source.recv(CHUNK)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        due = self.leg.in_order(time.monotonic())
        self.under_way.append((due, data))
        self.size += len(data)
        self.leg.counts["tcp_bytes"] += len(data)
        if not data or self.size > MOST_UNDER_WAY:
            self.relay.unwatch(self.source)
        self.relay.at(due, self.write)

    def write(self, now):
        self.relay.unwatch_writable(self.sink)
        if now < self.leg.dark_until:
            self.leg.kept.append(self.write)
            return
        while self.under_way and self.under_way[0][0] <= now and not self.ended:
            due, data = self.under_way.popleft()
            if not data:
                return self.connection.end(self)
            try:
                sent = self.sink.send(data)
            except BlockingIOError:
                sent = 0
            except OSError:
                return self.connection.close()
            self.size -= sent
            if sent < len(data):
                self.under_way.appendleft((due, data[sent:]))
                self.relay.watch_writable(self.sink, self.write)
                break
        if self.size <= MOST_UNDER_WAY and not (self.under_way
                                                and not self.under_way[-1][1]) and not self.ended:
            self.relay.watch(self.source, self.read)


class Connection:
    def __init__(self, relay, site_side, up, down):
        self.relay = relay
        self.sockets = [site_side, socket.socket()]
        self.streams = []
        for end in self.sockets:
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            self.sockets[1].connect(relay.server)
        except OSError:
            return self.close()
        for end in self.sockets:
            end.setblocking(False)
        self.streams = [Stream(self, *self.sockets, up), Stream(self, *self.sockets[::-1], down)]

    def end(self, stream):
        stream.ended = True
        if all(other.ended for other in self.streams):
            return self.close()
        try:
            stream.sink.shutdown(socket.SHUT_WR)
        except OSError:
            self.close()

    def close(self):
        for stream in self.streams:
            stream.ended = True
            stream.under_way.clear()
        for end in self.sockets:
            self.relay.unwatch(end)
            self.relay.unwatch_writable(end)
            end.close()


def datagram_socket():
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.setblocking(False)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    made.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
    return made


def received(source):
    """(bytes, when the kernel had them, from where) of what has come: a relay that slept adds no delay to a
    longer one."""
    for _ in range(DATAGRAMS_A_ROUND):
        try:
            data, ancillary, _, address = source.recvmsg(2048, 64)
        except (BlockingIOError, ConnectionRefusedError):
            return
        age = 0.0
        for level, kind, stamp in ancillary:
            if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS:
                seconds, nanoseconds = struct.unpack("@qq", stamp[:16])
                age = time.time() - (seconds + 1e-9 * nanoseconds)
        yield data, time.monotonic() - min(max(age, 0.0), 1.0), address


class Relay:
    def __init__(self, server, sites, conditions, seed):
        self.server = server
        self.readers, self.writers = {}, {}
        self.due, self.numbers = [], itertools.count()
        self.late = array.array("d")  # s, of datagrams
        self.conditions = dict(CONDITIONS)
        self.change(conditions)
        self.legs = [(Leg(self.conditions, f"{seed} {site} up"), Leg(self.conditions, f"{seed} {site} down"))
                     for site in range(sites)]
        self.ports = [self.open(*legs) for legs in self.legs]

    def open(self, up, down):
        """A port for TCP and UDP alike."""
        for _ in range(32):
            listener, own = socket.socket(), datagram_socket()
            listener.bind(("127.0.0.1", 0))
            try:
                own.bind(listener.getsockname())
            except OSError:
                continue
            listener.listen()
            self.watch(listener, lambda: Connection(self, listener.accept()[0], up, down))
            Datagrams(self, own, up, down)
            return listener.getsockname()[1]
        sys.exit("network_relay: no port is free for TCP and UDP alike")

    def watch(self, source, act):
        self.readers[source] = act

    def unwatch(self, source):
        self.readers.pop(source, None)

    def watch_writable(self, sink, act):
        self.writers[sink] = act

    def unwatch_writable(self, sink):
        self.writers.pop(sink, None)

    def at(self, due, act, timed=False):
        heapq.heappush(self.due, (due, next(self.numbers), act, timed))

    def change(self, conditions):
        for name, value in conditions.items():
            if name not in CONDITIONS or not isinstance(value, (int, float)) or value < 0:
                raise ValueError(f"unknown condition {name}: {value}")
            if name != "one_way_ms" and value > 1:
                raise ValueError(f"{name} is a share, not {value}")
        self.conditions.update(conditions)

    def black_out(self, for_s, site=None, burst=False):
        until = time.monotonic() + for_s
        for leg in itertools.chain(*(self.legs if site is None else [self.legs[site]])):
            leg.dark_until, leg.burst = until, burst
            self.at(until, leg.lift)

    def order(self, what):
        if "blackout" in what:
            self.black_out(**what["blackout"])
        elif "report" in what:
            print(json.dumps(self.report()), flush=True)
        else:
            self.change(what)

    def turn(self, longest):
        """Waits for what comes, and passes on what is due; s."""
        wait = min(longest, self.due[0][0] - time.monotonic()) if self.due else longest
        readable, writable, _ = select.select(list(self.readers), list(self.writers), [], max(wait, 0.0))
        for source in readable:
            if source in self.readers:
                self.readers[source]()
        now = time.monotonic()
        for sink in writable:
            if sink in self.writers:
                self.writers[sink](now)
        while self.due and self.due[0][0] <= now:
            due, _, act, timed = heapq.heappop(self.due)
            if timed:
                self.late.append(time.monotonic() - due)
            act(now)

    def report(self):
        late = sorted(self.late) or [0.0]
        share = lambda q: 1e3 * late[min(len(late) - 1, int(q * len(late)))]
        return {"late_ms": {"p50": share(0.5), "p99": share(0.99), "max": 1e3 * late[-1]},
                "sites": [{"up": dict(up.counts), "down": dict(down.counts)} for up, down in self.legs]}


def run(relay, network, duration, orders):
    start = time.monotonic()
    end = start + duration
    for step in network.pop("steps", []):
        relay.at(start + step.pop("at"), lambda _, step=step: relay.change(step))
    for blackout in network.pop("blackouts", []):
        relay.at(start + blackout.pop("at"), lambda _, blackout=blackout: relay.black_out(**blackout))
    ended = False
    rest = b""

    def read_orders():
        nonlocal ended, rest
        read = os.read(0, CHUNK)
        ended = not read
        *lines, rest = (rest + read).split(b"\n")
        for line in lines:
            relay.order(json.loads(line))

    if orders:
        relay.watch(0, read_orders)
    while not ended and time.monotonic() < end:
        relay.turn(min(1.0, max(0.0, end - time.monotonic())))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", required=True, help="HOST:PORT of tandem-server, IPv4")
    parser.add_argument("--sites", type=int, default=2)
    parser.add_argument("--network", type=json.loads, default={}, help="conditions, JSON")
    parser.add_argument("--seed", default="1")
    parser.add_argument("--duration", type=float, default=600.0, help="s")
    parser.add_argument("--orders", action="store_true",
                        help="take changes from standard input, and end with it")
    arguments = parser.parse_args()
    host, _, port = arguments.server.rpartition(":")
    gc.disable()
    try:
        # A network is not held up by what machines do.
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    except PermissionError:
        pass
    conditions = {name: value for name,
                  value in arguments.network.items() if name not in ("steps", "blackouts")}
    relay = Relay((host, int(port)), arguments.sites, conditions, arguments.seed)
    print(json.dumps({"ports": relay.ports}), flush=True)
    try:
        run(relay, arguments.network, arguments.duration, arguments.orders)
    except KeyboardInterrupt:
        pass
    print(json.dumps(relay.report()), flush=True)


if __name__ == "__main__":
    main()
