// What every view uses: answers of the server, and the colours of the page.
export const ask = async (path, options) => {
  const response = await fetch(path, options);
  if (response.ok) return response;
  const said = await response.text();
  let sentence = said;
  try { sentence = JSON.parse(said).error; } catch { /* a plain sentence */ }
  throw Object.assign(new Error(sentence), { status: response.status });
};
export const askJson = async (path) => (await ask(path)).json();
export const post = async (path, data) => (await ask(path, {
  method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data),
})).json();
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
export const byId = (id) => document.getElementById(id);

// Samples come as times (float64, s), heights (float32, m), and what is beside, in thousands of its unit (float32).
export const samplesOf = async (run, { samples: count, beside }) => {
  const data = await (await ask(`/api/runs/${encodeURIComponent(run)}/samples`)).arrayBuffer();
  return {
    time: new Float64Array(data, 0, count),
    height: new Float32Array(data, 8 * count, count),
    beside: beside.map((title, place) => ({ title, values: new Float32Array(data, (12 + 4 * place) * count, count) })),
  };
};

const AGAIN_MS = 2000;
const lost = (message) => { byId("lost").textContent = message; };

// Returns what calls `look` until it is answered, and does so when the book has entries that the page was not made with.
// A page that nobody sees listens to nothing: browsers allow few connections.
export const onChange = (look) => {
  let events = null;
  let last = Number(document.body.dataset.entries);
  const again = async () => {
    try {
      await look(last);
      lost("");
    } catch (error) {
      lost(error.status ? error.message : "no answer from labbook");
      setTimeout(again, AGAIN_MS);
    }
  };
  const listen = () => {
    events = new EventSource("/api/events");
    events.addEventListener("open", () => lost(""));
    events.addEventListener("error", () => lost(
      events.readyState === EventSource.CLOSED ? "labbook was started anew: open the address that it printed" : "no answer from labbook",
    ));
    events.addEventListener("message", (event) => {
      const now = JSON.parse(event.data).entries;
      const news = now !== last;
      last = now;
      if (news) again();
    });
  };
  document.addEventListener("visibilitychange", () => {
    events?.close();
    events = null;
    if (!document.hidden) listen();
  });
  if (!document.hidden) listen();
  return again;
};
