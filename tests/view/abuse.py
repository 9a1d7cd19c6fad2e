#!/usr/bin/env python3
"""Treats the server of `photosite view` as no browser would, and checks what it still does.

    abuse.py PHOTOSITE

Strangers (without the token, from other pages, by other names), names of files outside of the input, requests that are
none, a hundred connections, readers that do not read: each is refused or served, the memory stays bounded, and in the end
the page answers as in the beginning.

Needs nothing but Python.
"""

import errno
import json
import os
import random
import re
import socket
import struct
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

CAPTURE = Path(__file__).resolve().parents[2] / "scenes/cornell-box/capture.toml"
# What lies on every Linux machine, and never in an answer.
SECRET_FILE, SECRET = "/etc/passwd", b"root:"
# Most that the process may grow by in all, above what one image of this size takes many times over.
MEMORY_BYTES = 200 << 20


class Server:
    """A server that shows the Cornell box, small."""

    def __init__(self, photosite, folder):
        command = [photosite, "view", CAPTURE, "--set", "sensor.resolution_px=[160,120]",
                   "--set", "render.samples_per_pixel=16"]
        self.log = Path(folder) / "log"
        self.process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=self.log.open("w"), text=True)
        address = self.process.stdout.readline()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/([0-9a-f]{32})/\n", address)
        assert found, f"{address!r} is no address with a token of 128 bits"
        self.port, self.token = int(found[1]), found[2]

    def end(self):
        self.process.terminate()
        return self.process.wait(timeout=20)

    def memory(self):
        text = Path(f"/proc/{self.process.pid}/status").read_text()
        return 1024 * int(re.search(r"VmRSS:\s+(\d+) kB", text)[1])

    def connect(self, timeout=20):
        return socket.create_connection(("127.0.0.1", self.port), timeout=timeout)

    def host(self):
        return f"127.0.0.1:{self.port}"

    def ask(self, path, *, method="GET", host=None, body=b"", headers=()):
        """Status, headers and body of the answer to a request that is written by hand."""
        lines = [f"{method} {path} HTTP/1.1", f"Host: {host or self.host()}", "Connection: close"]
        lines += [f"{name}: {value}" for name, value in headers]
        if body:
            lines.append(f"Content-Length: {len(body)}")
        with self.connect() as connection:
            connection.sendall("\r\n".join([*lines, "", ""]).encode("latin-1") + body)
            return parsed(everything(connection))

    def own(self, path, **more):
        return self.ask(f"/{self.token}/{path}", **more)

    def picture(self, query="plane=developed"):
        """An image, waited for while there is no light yet, or others take all places."""
        for _ in range(600):
            status, _, body = self.own(f"picture?{query}")
            if status not in (409, 503):
                assert status == 200, body
                return body
            time.sleep(0.1)
        raise AssertionError("no image within a minute")

    def wait_until_done(self):
        with self.connect(timeout=120) as connection:
            connection.sendall(f"GET /{self.token}/events HTTP/1.1\r\nHost: {self.host()}\r\n\r\n".encode())
            seen = b""
            while b'"phase":"done"' not in seen:
                data = connection.recv(1 << 16)
                assert data, seen[-500:]
                seen += data


def everything(connection):
    data = b""
    try:
        while more := connection.recv(1 << 16):
            data += more
    except (ConnectionResetError, BrokenPipeError):
        pass
    return data


def parsed(answer):
    """0 for a connection that was closed without a word."""
    head, _, body = answer.partition(b"\r\n\r\n")
    lines = head.decode("latin-1").split("\r\n")
    status = int(lines[0].split()[1]) if lines[0].startswith("HTTP/1.") else 0
    headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines[1:])}
    return status, headers, body


def strangers_are_refused(server):
    token, wrong = server.token, "0" * 32
    for path in ["/", "/about", "/picture", f"/{wrong}/", f"/{wrong}/picture", f"/{token[:-1]}/", f"/{token}0/",
                 f"/{token.upper()}/" if token.upper() != token else "/x/", f"//{token}/", f"/?token={token}", f"/x/{token}/"]:
        status, _, body = server.ask(path)
        assert status == 403, (path, status)
        assert b"<html" not in body and token.encode() not in body, path
    for host in ["evil.example", f"evil.example:{server.port}", "127.0.0.1.evil.example", "localhost.evil.example",
                 "evil.example@127.0.0.1", "127.0.0.1@evil.example"]:
        assert server.own("about", host=host)[0] in (400, 403), host
    for origin in ["http://evil.example", "null", "https://" + server.host(), "http://127.0.0.1:1", "file://"]:
        for method, path in [("GET", "about"), ("GET", "picture"), ("POST", "trace")]:
            status = server.own(path, method=method, body=b'{"do": "stop"}' if method == "POST" else b"",
                                headers=[("Origin", origin), ("Content-Type", "text/plain")])[0]
            assert status == 403, (origin, path, status)
    for site in ["cross-site", "same-site"]:
        assert server.own("picture", headers=[("Sec-Fetch-Site", site), ("Sec-Fetch-Mode", "no-cors")])[0] == 403, site
    # Two hosts in one request: neither may be taken for the other.
    both = f"GET /{token}/about HTTP/1.1\r\nHost: {server.host()}\r\nHost: evil.example\r\nConnection: close\r\n\r\n"
    with server.connect() as connection:
        connection.sendall(both.encode())
        status = parsed(everything(connection))[0]
    assert status in (400, 403), status
    assert server.own("")[0] == 200


def answers_keep_to_themselves(server):
    """No other page may read, frame or keep what is answered, and the token goes nowhere."""
    for path in ["", "about", "picture", "view.js"]:
        status, headers, _ = server.own(path)
        assert status == 200, (path, status)
        assert "access-control-allow-origin" not in headers
        assert headers["cache-control"] == "no-store"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["cross-origin-resource-policy"] == "same-origin"
        policy = headers["content-security-policy"]
        assert "default-src 'self'" in policy and "frame-ancestors 'none'" in policy, policy


def files_stay_unread(server):
    climbs = ["../../../../../../../../etc/passwd", "..%2f..%2f..%2f..%2f..%2f..%2fetc%2fpasswd", "/etc/passwd", "%2fetc%2fpasswd",
              "%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd", "....//....//etc/passwd", "..\\..\\..\\etc\\passwd", "file:///etc/passwd",
              "view.js/../../../../etc/passwd", "view.js%00", "%c0%ae%c0%ae/etc/passwd"]
    for climb in climbs:
        status, _, body = server.own(climb)
        assert status in (400, 403, 404) and SECRET not in body, (climb, status)
    absolute = f"http://{server.host()}/{server.token}/../../etc/passwd"
    assert server.ask(absolute)[0] in (400, 403, 404)
    for key in ["sensor.preset", "develop.demosaic", "exposure.stages_off", "plane", "input", "frame", "scene.geometry",
                "scene.environment.image", "output.raw", "lens.prescription", "file"]:
        for value in [SECRET_FILE, "../" * 12 + "etc/passwd", f"[\"{SECRET_FILE}\"]"]:
            for path in ["picture", "capture", "pixel"]:
                status, _, body = server.own(f"{path}?{key}={value.replace('/', '%2F')}")
                # Changes and pixels are told whatever plane is looked at.
                told = path != "picture" and key == "plane" and status == 200
                assert told or status in (400, 404), (path, key, value, status, body)
                assert SECRET not in body
    lists = [{"scene.geometry": [SECRET_FILE]}, {"scene.environment.image": SECRET_FILE}, {"scene.environment": {"image": SECRET_FILE}},
             {"sensor.preset": SECRET_FILE}, {"materials.white.reflectance": {"file": SECRET_FILE}}, {"output.raw": ["dng"]},
             {"materials.white": {"type": "diffuse", "reflectance": {"file": SECRET_FILE}}}, {"lens.prescription": SECRET_FILE},
             {"camera.position_m": SECRET_FILE}, {"camera.position_m": [0, 0, {"file": SECRET_FILE}]}, {"camera": {"gltf_camera": "x"}},
             {"lens.f_number": f"1\n[scene]\ngeometry = [\"{SECRET_FILE}\"]"}, {f"lens.f_number = 1\nscene.geometry": [SECRET_FILE]}]
    for changes in lists:
        status, _, body = server.own("trace", method="POST", body=json.dumps({"do": "start", "changes": changes}).encode())
        assert status == 400, (changes, status)
        assert SECRET not in body


def orders_that_are_none(server):
    bodies = [b"", b"{", b"[]", b"null", b'{"do": "eat"}', b'{"do": "start", "changes": 1}', b'{"do": "start", "changes": ["a"]}', b'{"do": "start", "changes": {"a": 1}}',
              b'{"do": "start", "changes": {"lens.f_number": {}}}', b'{"do": "stop", "more": 1}', b"\xff\xfe", b"[" * 60000, b"0" * 64000]
    for body in bodies:
        status = server.own("trace", method="POST", body=body)[0]
        assert status == 400, (body[:40], status)
    assert server.own("trace", method="POST", body=b'"' + b"a" * (1 << 20) + b'"')[0] in (0, 413)
    for method in ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "BREW"]:
        assert server.own("trace", method=method)[0] in (400, 404, 405, 501), method
    queries = ["plane=", "plane=x", "plane=electrons:", "plane=electrons:" + "R" * 3000, "frame=-1", "frame=99999999999", "input=7",
               "exposure.time_s=nan", "exposure.time_s=inf", "exposure.time_s=-1", "exposure.time_s=1e308", "exposure.time_s=0",
               "exposure.gain_db=1e9", "exposure.temperature_c=-1e9", "develop.sharpening=-1e30", "exposure.time_s=1%0A%5Bx%5D", "%ff=1", "a", "=",
               "&".join(["exposure.gain_db=0"] * 100_000), "x=" + "y" * 100_000]
    for query in queries:
        status, _, body = server.own(f"picture?{query}")
        assert status in (0, 400, 404, 409, 414, 431), (query[:60], status, body[:200])


def noise_is_no_request(server):
    rng = random.Random(7)
    tls = bytes.fromhex("16030100a5010000a10303")
    upgrade = (f"GET /{server.token}/events HTTP/1.1\r\nHost: {server.host()}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
               "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n").encode()
    frame = b"".join(struct.pack(">BBQ", 0x82, 0xFF, 1 << 62) + rng.randbytes(4000) for _ in range(4))
    head = f"POST /{server.token}/trace HTTP/1.1\r\nHost: {server.host()}\r\n".encode()
    cases = [tls + rng.randbytes(200), b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"\0" * 10000, rng.randbytes(100_000), b"\r\n" * 5000,
             b"GET / HTTP/9.9\r\n\r\n", b"GET\r\n\r\n", b"GET /" + b"a" * (1 << 20), head + b"X: " + b"y" * (1 << 20) + b"\r\n\r\n",
             head + b"".join(b"X-%d: y\r\n" % i for i in range(5000)) + b"\r\n", head + b"Content-Length: -1\r\n\r\n",
             head + b"Content-Length: 99999999999999999999\r\n\r\n", head + b"Content-Length: 5\r\nContent-Length: 6\r\n\r\nabcdef",
             head + b"Transfer-Encoding: chunked\r\n\r\nzz\r\n", head + b"Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n",
             head + b"Transfer-Encoding: chunked\r\nContent-Length: 4\r\n\r\n0\r\n\r\n", upgrade + frame]
    for case in cases:
        with server.connect() as connection:
            try:
                connection.sendall(case)
                connection.shutdown(socket.SHUT_WR)
                connection.settimeout(15)
                data = connection.recv(1 << 16)
            except ConnectionError:
                data = b""
            except OSError as broken:
                # It may be closed before both sides are.
                if broken.errno != errno.ENOTCONN:
                    raise
                data = b""
            status = parsed(data)[0]
            # A garbage frame after an upgrade that is not taken comes after an answer of its own.
            served = case is cases[-1] and status == 200
            assert served or status in (0, 400, 403, 404, 405, 408, 411, 413, 414, 431, 501, 505), (case[:60], data[:200])
            assert status != 101, "there are no WebSockets"


@contextmanager
def connections(server, count, request):
    opened = []
    try:
        for _ in range(count):
            connection = server.connect()
            connection.sendall(request)
            opened.append(connection)
        yield opened
    finally:
        for connection in opened:
            connection.close()


def a_hundred_connections(server):
    """Those that say nothing, begin to, listen, or ask for images: who comes after them is answered while they stay, in whatever time a
    busy machine takes."""
    head = f" HTTP/1.1\r\nHost: {server.host()}\r\n"
    kinds = {
        "silent": b"",
        "half a request": f"GET /{server.token}/".encode(),
        "half its head": f"GET /{server.token}/{head}".encode(),
        "half a body": f"POST /{server.token}/trace{head}Content-Length: 100\r\n\r\n".encode() + b"{",
        "events": f"GET /{server.token}/events{head}\r\n".encode(),
        "pictures": f"GET /{server.token}/picture{head}\r\n".encode(),
        "strangers": f"GET /{head}\r\n".encode(),
    }
    for kind, request in kinds.items():
        start = time.monotonic()
        with connections(server, 100, request):
            status = server.own("about")[0]
            took = time.monotonic() - start
            assert status in (200, 503) and took < 90, (kind, status, took)
        assert server.own("about")[0] == 200, kind
        print(f"  100 connections, {kind}: answered with {status} after {took:.1f} s")


def readers_that_do_not_read(server):
    """Images pile up nowhere: a reader of a byte a second costs others nothing."""
    request = f"GET /{server.token}/picture?plane=raw HTTP/1.1\r\nHost: {server.host()}\r\n\r\n".encode()
    before = server.memory()
    with connections(server, 40, request * 50) as slow:
        for connection in slow[:5]:
            connection.recv(1)
        for _ in range(5):
            start = time.monotonic()
            status = server.own("picture")[0]
            took = time.monotonic() - start
            assert status in (200, 503) and took < 90, (status, took)
        grown = server.memory() - before
    assert grown < MEMORY_BYTES, f"{grown >> 20} MiB for readers that do not read"
    print(f"  2000 images that nobody reads: {grown / (1 << 20):.0f} MiB")


CASES = [strangers_are_refused, answers_keep_to_themselves, files_stay_unread, orders_that_are_none, noise_is_no_request,
         a_hundred_connections, readers_that_do_not_read]


def main(photosite, *names):
    with tempfile.TemporaryDirectory() as folder:
        server = Server(os.path.abspath(photosite), folder)
        try:
            server.wait_until_done()
            first, begun = server.picture(), server.memory()
            for case in CASES:
                if names and case.__name__ not in names:
                    continue
                print(case.__name__.replace("_", " "), flush=True)
                case(server)
                assert server.process.poll() is None, f"the server has ended: {server.log.read_text()}"
            # The head of an image tells how long it took.
            values = 3 * 160 * 120
            assert server.picture()[-values:] == first[-values:], "another image than in the beginning"
            grown = server.memory() - begun
            assert grown < MEMORY_BYTES, f"{grown >> 20} MiB more than in the beginning"
            print(f"the page answers as in the beginning, with {grown / (1 << 20):.0f} MiB more")
        finally:
            status = server.end()
        log = server.log.read_text()
        assert "panicked" not in log, log
        assert status == 143, status


if __name__ == "__main__":
    main(*sys.argv[1:])
