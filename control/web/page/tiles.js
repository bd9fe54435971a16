// The grid: a small live picture of every camera that is in view.
import { LiveReader, Painter } from './live.js';
import { listen, select, state } from './state.js';

const mostCameras = 64;  // of one stream
const grid = document.getElementById('tiles');
const tiles = new Map();
let visible = false;
const inView = new Set();
const reader = new LiveReader(
  ({ camera, blob }) => tiles.get(camera)?.painter.paint(blob),
  (problem) => { for (const tile of tiles.values()) tile.facts.textContent = problem; });

const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (entry.isIntersecting) inView.add(entry.target.dataset.camera);
    else inView.delete(entry.target.dataset.camera);
  }
  readOn();
}, { rootMargin: '100px' });

function readOn() {
  const wanted = visible ? state.cameras.filter((camera) => inView.has(camera.name)).slice(0, mostCameras) : [];
  reader.want(wanted, 'width=320&fps=15&quality=70');
}

function addTile(camera) {
  const button = document.createElement('button');
  button.type = 'button';
  button.className = 'tile';
  button.dataset.camera = camera.name;
  const canvas = document.createElement('canvas');
  canvas.setAttribute('aria-hidden', 'true');
  [canvas.width, canvas.height] = [320, Math.round(320 * camera.size[1] / camera.size[0])];
  const name = document.createElement('b');
  name.textContent = camera.name;
  const facts = document.createElement('span');
  button.append(canvas, name, facts);
  button.addEventListener('click', () => select(camera.name));
  grid.append(button);
  const tile = { button, facts, painter: new Painter(canvas), framesBefore: 0, at: performance.now(), key: '' };
  tiles.set(camera.name, tile);
  watcher.observe(button);
  return tile;
}

function showCameras() {
  const names = new Set(state.cameras.map((camera) => camera.name));
  for (const [name, tile] of tiles) {
    if (names.has(name)) continue;
    watcher.unobserve(tile.button);
    inView.delete(name);
    tile.button.remove();
    tiles.delete(name);
  }
  for (const camera of state.cameras) {
    const tile = tiles.get(camera.name) ?? addTile(camera);
    tile.button.setAttribute('aria-pressed', String(camera.name === state.selected));
    tile.button.setAttribute('aria-label', `Show camera ${camera.name} large, ${camera.size.join(' by ')}, ${camera.fps} frames a second`);
  }
}

function showRates() {
  const now = performance.now();
  for (const camera of state.cameras) {
    const tile = tiles.get(camera.name);
    if (!tile) continue;
    const rate = (tile.painter.frames - tile.framesBefore) / (now - tile.at) * 1000;
    [tile.framesBefore, tile.at] = [tile.painter.frames, now];
    tile.facts.textContent = `${camera.size.join('×')} · ${camera.fps} Hz · shown ${rate.toFixed(0)}`;
  }
}

listen((_, stage) => {
  showCameras();
  if (stage === 'stats') showRates();
  readOn();
});

export function show() { visible = true; readOn(); }
export function hide() { visible = false; readOn(); }
