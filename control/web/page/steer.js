// Moves the camera that is shown large: buttons, keys, dragging the picture, the wheel.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { aimHead, driveHead, haltHead, hasHead, stepHead, zoomHeadTo, zoomOf } from './head.js';
import { adopt, selectedCamera } from './state.js';

const view = document.getElementById('view');
const pads = document.getElementById('pads');
const repeatMs = 120;
const coarse = { turn: 4, move: 0.25, zoom: 1.1 };
const fine = { turn: 0.5, move: 0.03, zoom: 1.02 };
const rad = Math.PI / 180;

// Changes of one camera: one call is on its way, and what is wished meanwhile goes with the next one, merged. `wished`
// holds all of it until the rig has answered, so that what follows starts from there and not from an older look.
const waiting = new Map();
const wished = new Map();

export function change(name, wish) {
  const idle = !wished.has(name);
  waiting.set(name, { ...waiting.get(name), ...wish });
  wished.set(name, { ...wished.get(name), ...wish });
  if (idle) send(name);
}

async function send(name) {
  let answered = null;
  while (waiting.has(name)) {
    const wish = waiting.get(name);
    waiting.delete(name);
    answered = await attempt(() => call('camera.set', { name, ...wish }));
    if (!answered) waiting.delete(name);
  }
  wished.delete(name);
  if (answered) adopt(answered);
}

/** Where the camera is, or is about to be. */
export function poseOf(camera) {
  const { position, pan_deg, tilt_deg, roll_deg } = wished.get(camera.name)?.pose ?? camera.pose;
  return { position: [...position], pan_deg, tilt_deg, roll_deg };
}

export function turn(camera, pan, tilt) {
  if (hasHead(camera)) {
    stepHead(camera, pan / zoomOf(camera), tilt / zoomOf(camera));
    return;
  }
  const pose = poseOf(camera);
  pose.pan_deg = ((pose.pan_deg + pan + 540) % 360) - 180;
  pose.tilt_deg = Math.max(-89.9, Math.min(89.9, pose.tilt_deg + tilt));
  moveNow(camera, pose);
}

/** Metres along the camera's heading, to its left, and up. */
function move(camera, ahead, left, up) {
  const pose = poseOf(camera);
  const [c, s] = [Math.cos(pose.pan_deg * rad), Math.sin(pose.pan_deg * rad)];
  pose.position = [pose.position[0] + ahead * c - left * s, pose.position[1] + ahead * s + left * c, pose.position[2] + up];
  moveNow(camera, pose);
}

export function moveNow(camera, pose) { change(camera.name, { pose }); }

function zoom(camera, factor) {
  if (hasHead(camera)) {
    stepHead(camera, 0, 0, factor);
    return;
  }
  const wish = wished.get(camera.name) ?? {};
  // A fisheye has no field of view to set; its zoom scales the focal length.
  if (camera.lens.model === 'equidistant') {
    change(camera.name, { zoom: Math.max(1, Math.min(10, (wish.zoom ?? camera.zoom) * factor)) });
    return;
  }
  const half = Math.atan(Math.tan((wish.vfov_deg ?? camera.vfov_deg) * rad / 2) / factor) / rad;
  change(camera.name, { vfov_deg: Math.max(0.5, Math.min(170, 2 * half)), zoom: camera.zoom });
}

const actions = {
  'Pan left': ['◀', ['ArrowLeft'], (camera, by) => turn(camera, by.turn, 0)],
  'Pan right': ['▶', ['ArrowRight'], (camera, by) => turn(camera, -by.turn, 0)],
  'Tilt up': ['▲', ['ArrowUp'], (camera, by) => turn(camera, 0, by.turn)],
  'Tilt down': ['▼', ['ArrowDown'], (camera, by) => turn(camera, 0, -by.turn)],
  'Zoom in': ['+', ['+', '='], (camera, by) => zoom(camera, by.zoom)],
  'Zoom out': ['−', ['-', '_'], (camera, by) => zoom(camera, 1 / by.zoom)],
  'Move forward': ['W', ['w', 'W'], (camera, by) => move(camera, by.move, 0, 0)],
  'Move back': ['S', ['s', 'S'], (camera, by) => move(camera, -by.move, 0, 0)],
  'Move left': ['A', ['a', 'A'], (camera, by) => move(camera, 0, by.move, 0)],
  'Move right': ['D', ['d', 'D'], (camera, by) => move(camera, 0, -by.move, 0)],
  'Move up': ['E', ['e', 'E'], (camera, by) => move(camera, 0, 0, by.move)],
  'Move down': ['Q', ['q', 'Q'], (camera, by) => move(camera, 0, 0, -by.move)],
};
const byKey = new Map(Object.values(actions).flatMap(([, keys, act]) => keys.map((key) => [key, act])));

function perform(act, step) {
  const camera = selectedCamera();
  if (camera) act(camera, step);
}

function addPad(name, [face, , act]) {
  const pad = document.createElement('button');
  pad.type = 'button';
  pad.textContent = face;
  pad.setAttribute('aria-label', name);
  pad.title = name;
  let timer = 0;
  const stop = () => { clearInterval(timer); timer = 0; };
  pad.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    stop();
    perform(act, event.shiftKey ? fine : coarse);
    timer = setInterval(() => perform(act, event.shiftKey ? fine : coarse), repeatMs);
  });
  for (const end of ['pointerup', 'pointerleave', 'pointercancel', 'blur']) pad.addEventListener(end, stop);
  // A click without a pointer comes from the keyboard or a screen reader.
  pad.addEventListener('click', (event) => { if (event.detail === 0) perform(act, event.shiftKey ? fine : coarse); });
  pads.append(pad);
}
for (const [name, action] of Object.entries(actions)) addPad(name, action);

view.addEventListener('keydown', (event) => {
  const act = byKey.get(event.key);
  if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  perform(act, event.shiftKey && event.key !== '+' ? fine : coarse);
});

// A hand on the picture. One finger or the mouse turns the camera; two fingers zoom by how far they are apart.
let grabbed = null;
const fingers = new Map();
const spread = () => {
  const [a, b] = [...fingers.values()];
  return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
};
const leastPinch = 1.03;

function letGo(event) {
  fingers.delete(event.pointerId);
  if (grabbed) haltHead();
  grabbed = null;
}

view.addEventListener('pointerdown', (event) => {
  const camera = selectedCamera();
  if (!camera || event.button !== 0) return;
  view.focus({ preventScroll: true });
  view.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, event);
  if (fingers.size > 1) haltHead();
  grabbed = {
    name: camera.name, x: event.clientX, y: event.clientY, pose: poseOf(camera), spread: fingers.size === 2 ? spread() : 0, zoom: hasHead(camera) ? zoomOf(camera) : 1,
  };
});
view.addEventListener('pointermove', (event) => {
  const camera = selectedCamera();
  if (!grabbed || camera?.name !== grabbed.name || !fingers.has(event.pointerId)) return;
  fingers.set(event.pointerId, event);
  if (grabbed.spread) {
    const factor = spread() / grabbed.spread;
    if (Math.max(factor, 1 / factor) < leastPinch) return;
    // A head is on its way while the fingers go on: it is told where to, not by how much more.
    if (hasHead(camera)) return zoomHeadTo(camera, grabbed.zoom * factor);
    grabbed.spread *= factor;
    zoom(camera, factor);
    return;
  }
  const [dx, dy] = [event.clientX - grabbed.x, event.clientY - grabbed.y];
  if (hasHead(camera)) {
    const share = (way) => Math.max(-1, Math.min(1, way / (0.5 * view.clientHeight)));
    driveHead(camera, share(dx), share(-dy));
    return;
  }
  // The picture follows the hand: its height is the vertical field of view.
  const perPixel = camera.vfov_deg / view.clientHeight;
  const pose = { ...grabbed.pose };
  pose.pan_deg += dx * perPixel;
  pose.tilt_deg = Math.max(-89.9, Math.min(89.9, pose.tilt_deg + dy * perPixel));
  moveNow(camera, pose);
});
for (const end of ['pointerup', 'pointercancel']) view.addEventListener(end, letGo);
view.addEventListener('dblclick', (event) => {
  const camera = selectedCamera();
  if (!hasHead(camera)) return;
  const box = view.getBoundingClientRect();
  aimHead(camera, 2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
});
view.addEventListener('wheel', (event) => {
  if (document.activeElement !== view) return;  // a page that is scrolled past the picture zooms nothing
  event.preventDefault();
  perform(zoomBy(event.deltaY), coarse);
}, { passive: false });

function zoomBy(delta) { return (camera, by) => zoom(camera, delta < 0 ? by.zoom : 1 / by.zoom); }
