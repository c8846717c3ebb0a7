// The way to the module: the same words as those of the workbench's socket.
export class Local extends EventTarget {
  known = false; state = null;
  #asked = new Map(); #next = 1;

  constructor(files) {
    super();
    this.worker = new Worker('worker.js');
    this.worker.onmessage = e => this.#hear(e.data);
    this.worker.onerror = e => this.#tell('broken', e.message);
    this.ask({ hello: { files } });
  }
  // Asks for something; rejects with words when it is refused.
  ask(wish) {
    return new Promise((done, refused) => {
      const ask = this.#next++;
      this.#asked.set(ask, { done, refused });
      this.worker.postMessage({ ask, do: wish });
    });
  }
  // Says something whose answer nobody waits for.
  say(wish) {
    this.worker.postMessage({ do: wish });
  }
  #tell(name, detail) { this.dispatchEvent(new CustomEvent(name, { detail })); }
  #hear(data) {
    if (data instanceof ArrayBuffer) { this.#tell('path', data); return; }
    const name = Object.keys(data)[0], value = data[name];
    if (name === 'done' || name === 'refused') {
      const asked = this.#asked.get(value.ask);
      this.#asked.delete(value.ask);
      if (name === 'done') asked?.done(value.words);
      else if (asked) asked.refused(new Error(value.words));
      return;
    }
    if (name === 'welcome') this.known = true;
    this.#tell(name, value);
  }
}
