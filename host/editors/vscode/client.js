// A JSON-RPC line to the language server on its standard input and output.
'use strict';
const { spawn } = require('child_process');

class Client {
  #next = 1; #asked = new Map(); #buffer = Buffer.alloc(0); #child;

  // `heard` gets notifications, `ended` the reason when the server goes.
  constructor(command, args, heard, ended) {
    this.heard = heard;
    this.#child = spawn(command, args, { stdio: ['pipe', 'pipe', 'inherit'] });
    this.#child.on('error', error => this.#end(ended, error.message));
    this.#child.on('exit', code => this.#end(ended, `it ended with code ${code}`));
    this.#child.stdout.on('data', data => this.#take(data));
    this.#child.stdin.on('error', () => {}); // told by `exit`
  }
  #end(ended, words) {
    for (const { fail } of this.#asked.values()) fail(new Error(words));
    this.#asked.clear();
    if (!this.over) { this.over = true; ended(words); }
  }
  #take(data) {
    this.#buffer = Buffer.concat([this.#buffer, data]);
    for (;;) {
      const head = this.#buffer.indexOf('\r\n\r\n');
      if (head < 0) return;
      const length = /Content-Length: (\d+)/i.exec(this.#buffer.toString('ascii', 0, head));
      const end = head + 4 + Number(length?.[1] ?? 0);
      if (this.#buffer.length < end) return;
      const message = JSON.parse(this.#buffer.toString('utf8', head + 4, end));
      this.#buffer = this.#buffer.subarray(end);
      const asked = this.#asked.get(message.id);
      if (asked && !message.method) {
        this.#asked.delete(message.id);
        if (message.error) asked.fail(new Error(message.error.message));
        else asked.done(message.result ?? null);
      } else if (message.method) this.heard(message.method, message.params);
    }
  }
  #say(message) {
    const body = Buffer.from(JSON.stringify({ jsonrpc: '2.0', ...message }));
    if (!this.over) this.#child.stdin.write(Buffer.concat([Buffer.from(`Content-Length: ${body.length}\r\n\r\n`), body]));
  }
  tell(method, params) { this.#say({ method, params }); }
  ask(method, params) {
    const id = this.#next++;
    return new Promise((done, fail) => {
      if (this.over) { fail(new Error('the language server has ended')); return; }
      this.#asked.set(id, { done, fail });
      this.#say({ id, method, params });
    });
  }
  // Says good-bye; resolves when the server has gone.
  async close() {
    if (this.over) return;
    const gone = new Promise(done => this.#child.once('exit', done));
    await this.ask('shutdown').catch(() => {});
    this.#say({ method: 'exit' });
    this.over = true;
    await gone;
  }
}
module.exports = { Client };
