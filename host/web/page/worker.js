// The module in a thread of its own: a long simulation never holds the page up.
const encoder = new TextEncoder(), decoder = new TextDecoder();
let own = null, wanted = false;

const begun = fetch('pasapas.wasm')
  .then(answer => { if (!answer.ok) throw new Error(`pasapas.wasm: ${answer.status}`); return answer.arrayBuffer(); })
  .then(bytes => WebAssembly.instantiate(bytes))
  .then(({ instance }) => { own = instance.exports; });

function hear(message) {
  const bytes = encoder.encode(JSON.stringify(message));
  const at = own.input(bytes.length);
  new Uint8Array(own.memory.buffer, at, bytes.length).set(bytes);
  own.hear();
  for (let kind; (kind = own.next());) {
    const from = own.output(), part = own.memory.buffer.slice(from, from + own.length());
    if (kind === 1) postMessage(JSON.parse(decoder.decode(part))); else postMessage(part, [part]);
  }
}

// The newest text is simulated when everything that was said before is done.
function simulate() {
  if (wanted) return;
  wanted = true;
  setTimeout(() => { wanted = false; tried(() => hear({ do: 'simulate' })); });
}

// A module that failed once is in no state to go on.
function tried(run) {
  try { run(); } catch (error) { postMessage({ broken: String(error) }); own = null; }
}

onmessage = async ({ data }) => {
  try { await begun; } catch (error) { postMessage({ broken: String(error) }); return; }
  if (!own) return;
  tried(() => hear(data));
  if (data.do.text || data.do.open) simulate();
};
