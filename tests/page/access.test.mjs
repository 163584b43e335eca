// Who may ask the server, by plain HTTP.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { request } from "node:http";
import { connect } from "node:net";
import { networkInterfaces } from "node:os";
import { example, Server } from "./support/server.mjs";

let server = null;
const cleanups = [];
before(async () => (server = await Server.start({ after: (act) => cleanups.push(act) }, example("tshirt.usda"))));
after(() => Promise.all(cleanups.map((act) => act())));

/** The response to a raw path, which no library makes clean. */
function ask(path, { body, ...options } = {}) {
  return new Promise((resolve, reject) => {
    const asked = request({ host: "127.0.0.1", port: server.port, path, timeout: 5000, ...options });
    asked.on("response", async (response) => {
      let text = "";
      for await (const data of response) text += data;
      resolve({ status: response.statusCode, headers: response.headers, text });
    });
    asked.on("upgrade", (response, socket) => {
      socket.destroy();
      resolve({ status: response.statusCode, headers: response.headers, text: "" });
    });
    asked.on("error", reject);
    asked.end(body);
  });
}

const UPGRADE = {
  Connection: "Upgrade",
  Upgrade: "websocket",
  "Sec-WebSocket-Version": "13",
  "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
};

const own = (path = "") => `/${server.secret}/${path}`;

function assertHidden({ status, text }, statuses, words) {
  assert.ok(statuses.includes(status), `${words}: status ${status}`);
  assert.doesNotMatch(text, /html|script|usdtailor|preact/i, words);
}

test("the page is served below its secret, with headers that keep it in", async () => {
  for (const [name, type] of [
    ["", "text/html"],
    ["page.js", "text/javascript"],
    ["page.css", "text/css"],
  ]) {
    const { status, headers, text } = await ask(own(name));
    assert.ok(status === 200 && text.length > 300, name);
    assert.ok(headers["content-type"].startsWith(type), name);
    assert.equal(headers["x-content-type-options"], "nosniff");
    assert.equal(headers["cache-control"], "no-store");
    assert.equal(headers["referrer-policy"], "no-referrer");
    const policy = headers["content-security-policy"];
    for (const rule of ["default-src 'self'", "frame-ancestors 'none'", "base-uri 'none'"]) {
      assert.ok(policy.includes(rule), rule);
    }
    assert.doesNotMatch(policy, /unsafe-eval|script-src[^;]*unsafe-inline|https?:|\*/);
    assert.equal(headers["access-control-allow-origin"], undefined);
  }
  assert.ok(server.secret.length >= 32, "128 bits");
});

test("without the secret there is nothing", async () => {
  const wrong = server.secret.replace(/./g, (digit) => (digit === "0" ? "1" : "0"));
  const paths = [
    "/",
    "/index.html",
    "/page.js",
    "/socket",
    `/${wrong}/`,
    `/${wrong}/page.js`,
    `/${server.secret.slice(0, -1)}/`,
  ];
  for (const path of [...paths, `/${server.secret.toUpperCase()}A/`, "/favicon.ico", "//"]) {
    assertHidden(await ask(path), [403, 404], path);
    assertHidden(await ask(path, { headers: UPGRADE }), [403, 404], `socket at ${path}`);
  }
  const { headers } = await ask("/");
  assert.equal(headers["cache-control"], "no-store", "refusals have the headers too");
});

test("a name of somebody else that points here is refused", async () => {
  const hosts = [
    "evil.example",
    `evil.example:${server.port}`,
    "127.0.0.1",
    `127.0.0.1:${server.port + 1}`,
    "localhost",
  ];
  for (const host of hosts) assertHidden(await ask(own(), { headers: { Host: host } }), [403], host);
  assertHidden(await ask(own(), { setHost: false }), [400, 403], "no Host");
  assert.equal((await ask(own(), { headers: { Host: `localhost:${server.port}` } })).status, 200);
});

test("pages of other origins get neither the page nor the socket", async () => {
  const port = server.port;
  const origins = [
    "http://evil.example",
    "null",
    `https://127.0.0.1:${port}`,
    `http://127.0.0.1:${port + 1}`,
    `http://127.0.0.1:${port}.evil.example`,
  ];
  for (const Origin of origins) {
    assertHidden(await ask(own(), { headers: { Origin } }), [403], Origin);
    assertHidden(await ask(own("socket"), { headers: { ...UPGRADE, Origin } }), [403], `socket for ${Origin}`);
  }
  const allowed = await ask(own("socket"), { headers: { ...UPGRADE, Origin: `http://127.0.0.1:${port}` } });
  assert.equal(allowed.status, 101);
  const foreign = await ask(own("socket"), { headers: { ...UPGRADE, Host: "evil.example" } });
  assertHidden(foreign, [403], "socket for another Host");
});

test("paths lead nowhere else", async () => {
  const paths = [
    "../Cargo.toml",
    "../../etc/passwd",
    "%2e%2e/Cargo.toml",
    "..%2fCargo.toml",
    "%2e%2e%2fetc%2fpasswd",
    "..%5cCargo.toml",
  ];
  const more = [
    "page.js/../../Cargo.toml",
    "index.html.map",
    "page.js.LEGAL.txt",
    "/etc/passwd",
    "page.js%00",
    "src/main.tsx",
  ];
  for (const path of [...paths, ...more]) {
    const { status, text } = await ask(own(path));
    assert.equal(status, 404, path);
    assert.equal(text, "", path);
  }
});

test("only reading is allowed", async () => {
  for (const method of ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"]) {
    for (const path of [own(), own("page.js"), own("socket")]) {
      const { status, headers } = await ask(path, { method, body: method === "POST" ? "{}" : undefined });
      assert.ok(status >= 400 && status < 500, `${method} ${path}: ${status}`);
      assert.equal(headers["access-control-allow-methods"], undefined);
    }
  }
});

/** Whether anything listens there. */
function listens(host) {
  return new Promise((resolve) => {
    const socket = connect({ host, port: server.port, timeout: 1500 });
    const end = (is) => (socket.destroy(), resolve(is));
    socket.on("connect", () => end(true));
    socket.on("error", () => end(false));
    socket.on("timeout", () => end(false));
  });
}

test("only this machine can connect", async (t) => {
  assert.ok(await listens("127.0.0.1"));
  const others = Object.values(networkInterfaces())
    .flat()
    .filter(({ internal, scopeid }) => !internal && !scopeid);
  if (others.length === 0) return t.skip("the machine has no other address");
  for (const { address } of others) assert.equal(await listens(address), false, address);
});
