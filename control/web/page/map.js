// The world from above: cameras with what they see, and actors. Both can be dragged, with the pointer or with keys.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { hasHead, shownFov } from './head.js';
import { listen, select, state } from './state.js';
import { moveNow, poseOf, turn } from './steer.js';
import { colourOf } from './truth.js';

const mostActors = 500;
const reach = 46;                 // of a camera's wedge, in pixels
const map = document.getElementById('map');
const facts = document.getElementById('top-facts');
const svg = (name, attributes = {}) => {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
};
const background = svg('g', { 'aria-hidden': 'true' });
const actorLayer = svg('g');
const cameraLayer = svg('g');
map.append(background, actorLayer, cameraLayer);
const items = new Map();          // 'camera NAME' or 'actor NAME' -> {group, kind, name, ...}
let view = null;                  // middle of the map in metres, pixels per metre
let followed = true;              // all is shown until the user moves the map
let held = null;                  // what the pointer drags
const moving = new Map();         // actors that are being put elsewhere: name -> [x, y]

const toPixels = ([x, y]) => [(x - view.x) * view.scale + map.clientWidth / 2, (view.y - y) * view.scale + map.clientHeight / 2];
const toMetres = (px, py) => [(px - map.clientWidth / 2) / view.scale + view.x, view.y - (py - map.clientHeight / 2) / view.scale];

// The pose of a camera on a mount is in the frame of what carries it: it is shown where that has brought it, and goes where that goes.
const placeOf = (camera) => (camera.mount ? camera.world_pose : poseOf(camera));
const isCarried = (item) => item.kind === 'camera' && Boolean(state.cameras.find((one) => one.name === item.name)?.mount);

function fit() {
  const points = [...state.cameras.map((camera) => placeOf(camera).position), ...state.actors.slice(0, mostActors).map((actor) => actor.position)];
  const xs = points.map(([x]) => x);
  const ys = points.map(([, y]) => y);
  const [left, right, low, high] = points.length ? [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)] : [-5, 5, -5, 5];
  const scale = Math.min((map.clientWidth - 60) / Math.max(4, right - left), (map.clientHeight - 60) / Math.max(4, high - low));
  view = { x: (left + right) / 2, y: (low + high) / 2, scale: Math.max(0.01, scale) };
}

function drawGrid() {
  background.replaceChildren();
  const step = [0.5, 1, 2, 5, 10, 20, 50, 100, 500, 1000].find((one) => one * view.scale >= 40) ?? 5000;
  const [left, top] = toMetres(0, 0);
  const [right, bottom] = toMetres(map.clientWidth, map.clientHeight);
  for (let x = Math.ceil(left / step) * step; x <= right; x += step) {
    const [px] = toPixels([x, 0]);
    background.append(svg('line', { x1: px, x2: px, y1: 0, y2: map.clientHeight, class: x === 0 ? 'axis' : 'grid' }));
    const text = svg('text', { x: px + 3, y: map.clientHeight - 4, class: 'tick' });
    text.textContent = `${Number(x.toFixed(1))}`;
    background.append(text);
  }
  for (let y = Math.ceil(bottom / step) * step; y <= top; y += step) {
    const [, py] = toPixels([0, y]);
    background.append(svg('line', { x1: 0, x2: map.clientWidth, y1: py, y2: py, class: y === 0 ? 'axis' : 'grid' }));
    const text = svg('text', { x: 3, y: py - 3, class: 'tick' });
    text.textContent = `${Number(y.toFixed(1))}`;
    background.append(text);
  }
}

function itemOf(kind, name) {
  const key = `${kind} ${name}`;
  const found = items.get(key);
  if (found) return found;
  const group = svg('g', { class: kind, tabindex: '-1', role: 'button', 'data-name': name });
  const item = { key, kind, name, group };
  if (kind === 'camera') {
    item.wedge = svg('path', { class: 'wedge' });
    item.handle = svg('circle', { r: 6, class: 'handle' });
    group.append(item.wedge, item.handle, svg('circle', { r: 6.5, class: 'body' }));
    item.handle.addEventListener('pointerdown', (event) => grab(event, item, true));
  } else {
    group.append(svg('circle', { r: 5, class: 'body' }), svg('path', { d: 'M5 -3 L10 0 L5 3 Z', class: 'nose' }));
  }
  item.text = svg('text', { y: -10, class: 'name' });
  group.append(item.text);
  group.addEventListener('pointerdown', (event) => grab(event, item, false));
  group.addEventListener('keydown', (event) => steerItem(event, item));
  group.addEventListener('focus', () => { for (const one of items.values()) one.group.setAttribute('tabindex', one === item ? '0' : '-1'); });
  (kind === 'camera' ? cameraLayer : actorLayer).append(group);
  items.set(key, item);
  return item;
}

function drawCamera(camera) {
  const item = itemOf('camera', camera.name);
  const pose = placeOf(camera);
  const [x, y] = toPixels(pose.position);
  // A head turns and zooms what is seen; what is dragged is where it looks at pan 0.
  const looks = hasHead(camera) ? camera.world_pose.pan_deg : pose.pan_deg;
  const half = Math.min(175, hasHead(camera) ? shownFov(camera, camera.hfov_deg) : camera.hfov_deg) / 2;
  const at = (degrees, r) => [r * Math.cos(degrees * Math.PI / 180), -r * Math.sin(degrees * Math.PI / 180)];
  const far = Math.max(reach, Math.min(140, 5 * view.scale));
  const [from, to, middle] = [at(looks - half, far), at(looks + half, far), at(pose.pan_deg, far)];
  item.group.setAttribute('transform', `translate(${x} ${y})`);
  item.wedge.setAttribute('d', `M0 0 L${from[0]} ${from[1]} A${far} ${far} 0 0 0 ${to[0]} ${to[1]} Z`);
  item.handle.setAttribute('cx', middle[0]);
  item.handle.setAttribute('cy', middle[1]);
  item.group.setAttribute('aria-pressed', String(camera.name === state.selected));
  item.position = pose.position;
  name(item, `Camera ${camera.name}`, camera.name);
}

function drawActor(actor) {
  const item = itemOf('actor', actor.name);
  item.position = [...(moving.get(actor.name) ?? actor.position.slice(0, 2)), actor.position[2]];
  const [x, y] = toPixels(item.position);
  item.group.setAttribute('transform', `translate(${x} ${y})`);
  item.group.style.setProperty('--colour', colourOf(actor.id));
  item.group.children[1].setAttribute('transform', `rotate(${-actor.yaw_deg})`);
  item.actor = actor;
  name(item, `${actor.class} ${actor.name}`, view.scale > 8 ? actor.name : '');
}

function name(item, spoken, written) {
  item.text.textContent = written;
  item.group.setAttribute('aria-label', `${spoken} at ${item.position[0].toFixed(1)}, ${item.position[1].toFixed(1)} metres`);
}

function draw() {
  if (!map.clientWidth || map.clientHeight === 0) return;
  if (!view || (followed && !held)) fit();
  drawGrid();
  const actors = state.actors.slice(0, mostActors);
  const present = new Set([...state.cameras.map((one) => `camera ${one.name}`), ...actors.map((one) => `actor ${one.name}`)]);
  for (const [key, item] of items) if (!present.has(key)) { item.group.remove(); items.delete(key); }
  for (const actor of actors) drawActor(actor);
  for (const camera of state.cameras) drawCamera(camera);
  if (![...items.values()].some((item) => item.group.getAttribute('tabindex') === '0')) items.values().next().value?.group.setAttribute('tabindex', '0');
  facts.textContent = `${state.cameras.length} cameras, ${state.actors.length} actors` + (state.actors.length > mostActors ? `, ${mostActors} shown` : '');
}

async function putActor(actor, [x, y]) {
  moving.set(actor.name, [x, y]);
  draw();
  const position = [x, y, actor.position[2]];
  await attempt(() => call('actor.set', { name: actor.name, position }));
  moving.delete(actor.name);
}

function placeItem(item, [x, y], done) {
  if (isCarried(item)) return;
  if (item.kind === 'camera') {
    const camera = state.cameras.find((one) => one.name === item.name);
    const pose = poseOf(camera);
    pose.position = [x, y, pose.position[2]];
    moveNow(camera, pose);
  } else if (done) {
    putActor(item.actor, [x, y]);
  } else {
    moving.set(item.name, [x, y]);
  }
  draw();
}

function grab(event, item, turning) {
  if (event.button !== 0) return;
  event.stopPropagation();
  event.preventDefault();
  item.group.focus({ preventScroll: true });
  if (item.kind === 'camera') select(item.name);
  const [px, py] = toPixels(item.position);
  const box = map.getBoundingClientRect();
  held = { item, turning, dx: event.clientX - box.left - px, dy: event.clientY - box.top - py, moved: false };
  map.setPointerCapture(event.pointerId);
}

map.addEventListener('pointerdown', (event) => {
  if (event.button !== 0 || !view) return;
  held = { pan: true, x: event.clientX, y: event.clientY, from: { ...view } };
  map.setPointerCapture(event.pointerId);
});
map.addEventListener('pointermove', (event) => {
  if (!held) return;
  if (held.pan) {
    followed = false;
    view = { ...held.from, x: held.from.x - (event.clientX - held.x) / view.scale, y: held.from.y + (event.clientY - held.y) / view.scale };
    draw();
    return;
  }
  const box = map.getBoundingClientRect();
  held.at = toMetres(event.clientX - box.left - (held.turning ? 0 : held.dx), event.clientY - box.top - (held.turning ? 0 : held.dy));
  if (!held.turning) { placeItem(held.item, held.at, false); return; }
  const camera = state.cameras.find((one) => one.name === held.item.name);
  if (camera.mount) return;
  const pose = poseOf(camera);
  pose.pan_deg = Math.atan2(held.at[1] - pose.position[1], held.at[0] - pose.position[0]) * 180 / Math.PI;
  moveNow(camera, pose);
  draw();
});
map.addEventListener('pointerup', () => {
  if (held?.at && !held.turning && held.item.kind === 'actor') placeItem(held.item, held.at, true);
  held = null;
});
map.addEventListener('pointercancel', () => {
  if (held?.item) moving.delete(held.item.name);
  held = null;
});

function steerItem(event, item) {
  const far = event.shiftKey ? 2 : 0.25;
  const ways = { ArrowLeft: [-far, 0], ArrowRight: [far, 0], ArrowUp: [0, far], ArrowDown: [0, -far] };
  const camera = item.kind === 'camera' ? state.cameras.find((one) => one.name === item.name) : null;
  if (ways[event.key]) {
    const from = moving.get(item.name) ?? item.position;
    placeItem(item, [from[0] + ways[event.key][0], from[1] + ways[event.key][1]], true);
  } else if (event.key === 'PageDown' || event.key === 'PageUp') {
    const all = [...items.values()];
    const next = (all.indexOf(item) + (event.key === 'PageDown' ? 1 : all.length - 1)) % all.length;
    all[next].group.focus();
  } else if (camera && (event.key === 'Enter' || event.key === ' ')) {
    select(camera.name);
  } else if (camera && /^[rtRT]$/.test(event.key)) {
    turn(camera, event.key.toLowerCase() === 'r' ? 5 : -5, 0);
  } else {
    return;
  }
  event.preventDefault();
}

function scaleBy(factor) {
  if (!view) return;
  followed = false;
  view = { ...view, scale: Math.max(0.01, Math.min(500, view.scale * factor)) };
  draw();
}
map.addEventListener('wheel', (event) => {
  if (!map.contains(document.activeElement)) return;
  event.preventDefault();
  scaleBy(event.deltaY < 0 ? 1.15 : 1 / 1.15);
}, { passive: false });
document.getElementById('map-in').addEventListener('click', () => scaleBy(1.4));
document.getElementById('map-out').addEventListener('click', () => scaleBy(1 / 1.4));
document.getElementById('map-fit').addEventListener('click', () => { followed = true; draw(); });
new ResizeObserver(draw).observe(map);
listen(draw);
