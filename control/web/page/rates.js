// Rates, drops and latency, from the differences of two stats.get answers.
import { listen } from './state.js';

const table = document.getElementById('rate-table');
const head = ['Camera', 'Drawn/s', 'Dropped', 'Readers', 'Sent/s', 'Latency ms'];
let before = null;

const sum = (list, pick) => list.reduce((total, one) => total + pick(one), 0);

function rowOf(camera, then, seconds) {
  const readers = camera.outputs.flatMap((output) => output.readers);
  const earlier = then?.outputs.flatMap((output) => output.readers) ?? [];
  const sentBefore = sum(readers, (one) => earlier.find((old) => old.peer === one.peer && old.kind === one.kind)?.delivered ?? one.delivered);
  const dropped = camera.dropped + sum(camera.outputs, (output) => output.dropped + output.failed);
  const latency = Math.max(0, ...readers.map((one) => one.latency_ms));
  const rate = (count) => (seconds > 0 && then ? (count / seconds).toFixed(1) : '–');
  return [camera.name, rate(camera.rendered - (then?.rendered ?? 0)), dropped, readers.length,
    rate(sum(readers, (one) => one.delivered) - sentBefore), readers.length ? latency.toFixed(1) : '–'];
}

function row(cells, kind) {
  const line = document.createElement('tr');
  cells.forEach((text, index) => {
    const cell = document.createElement(index === 0 || kind === 'th' ? 'th' : 'td');
    if (kind === 'th') cell.scope = 'col';
    else if (index === 0) cell.scope = 'row';
    cell.textContent = text;
    line.append(cell);
  });
  return line;
}

listen(({ stats }, stage) => {
  if (stage !== 'stats' || stats === before) return;
  const seconds = before ? (stats.monotonic_ns - before.monotonic_ns) / 1e9 : 0;
  const then = new Map(before?.cameras.map((camera) => [camera.name, camera]));
  const stages = stats.stages.filter((one) => one.count).map((one) => `${one.name} ${one.p50_ms.toFixed(1)} / ${one.p99_ms.toFixed(1)}`).join(' · ');
  const caption = document.createElement('caption');
  caption.textContent = `${stats.instants} instants, ${stats.dropped_instants} with dropped pictures. Stages, p50 / p99 ms: ${stages}`;
  table.replaceChildren(caption, row(head, 'th'), ...stats.cameras.map((camera) => row(rowOf(camera, then.get(camera.name), seconds), 'td')));
  before = stats;
});
