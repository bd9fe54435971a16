// Cameras on pan/tilt/zoom heads (ptz.*): how they are driven, and the panel of where they look and of their presets.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { listen, selectedCamera } from './state.js';

const panel = document.getElementById('head');
const facts = document.getElementById('head-facts');
const presets = panel.querySelector('[name=preset]');
const fastest = { turn: 60, zoom: 1 };  // deg/s and share of the head's zoom speed at the picture's edge
// A continuous move ends by itself so soon after the page has gone; while it goes on, it is said anew.
const timeoutS = 1;
const againMs = 500;

export const hasHead = (camera) => Boolean(camera?.ptz);

// Per camera the newest request waits while one is on its way: a head is told where to go, not how the hand went there.
const waiting = new Map();

async function tellHead(name, method, params) {
  const idle = !waiting.has(name);
  waiting.set(name, [method, params]);
  if (!idle) return;
  for (let next = waiting.get(name); next; next = waiting.get(name)) {
    waiting.set(name, null);
    const answered = await attempt(() => call(next[0], { camera: name, ...next[1] }));
    if (answered) show(name, answered);
    else break;
  }
  waiting.delete(name);
}

// Relative steps that come while one is on its way are added up.
export function stepHead(camera, pan, tilt, zoom = 1) {
  const [method, before] = waiting.get(camera.name) ?? [];
  const sum = { pan_deg: 0, tilt_deg: 0, zoom: 1, ...(method === 'ptz.move' && before.mode === 'relative' ? before : {}) };
  const step = { mode: 'relative', pan_deg: sum.pan_deg + pan, tilt_deg: sum.tilt_deg + tilt, zoom: sum.zoom * zoom };
  // What a step does not move goes on with what it does.
  if (step.zoom === 1) delete step.zoom;
  if (!step.pan_deg && !step.tilt_deg) { delete step.pan_deg; delete step.tilt_deg; }
  tellHead(camera.name, 'ptz.move', { ...step });
}

/** Factor of the focal length that its head has brought. */
export const zoomOf = (camera) => camera.shown_intrinsics.fx / camera.intrinsics.fx;

let drive = null;  // { name, params, timer }

/** Goes on at that share of the fastest, -1 to 1, right and up positive, until haltHead(). */
export function driveHead(camera, right, up) {
  const turn = fastest.turn / zoomOf(camera);
  const params = { mode: 'continuous', pan_deg: -right * turn, tilt_deg: up * turn, timeout_s: timeoutS };
  const say = () => tellHead(drive.name, 'ptz.move', drive.params);
  if (drive) {
    drive.params = params;
  } else {
    drive = { name: camera.name, params, timer: setInterval(() => say(), againMs) };
  }
  say();
}

export function haltHead() {
  if (!drive) return;
  clearInterval(drive.timer);
  tellHead(drive.name, 'ptz.stop', { pan_tilt: true, zoom: false });
  drive = null;
}

/** What the picture shows there, -1 to 1 to the right and upwards, comes to its middle. */
export function aimHead(camera, x, y) { tellHead(camera.name, 'ptz.aim', { x, y }); }

function show(name, status) {
  if (selectedCamera()?.name !== name) return;
  const number = (value, digits) => String(Number(value.toFixed(digits)));
  facts.textContent = `pan ${number(status.pan_deg, 1)}° · tilt ${number(status.tilt_deg, 1)}° · zoom ${number(status.zoom, 2)} · ` +
    (status.turning || status.zooming ? 'moving' : 'stands');
  const names = Object.keys(status.presets);
  if (names.join('\n') === [...presets.options].map((option) => option.value).join('\n')) return;
  const chosen = presets.value;
  presets.replaceChildren(...names.map((one) => new Option(one)));
  if (names.includes(chosen)) presets.value = chosen;
  for (const button of panel.querySelectorAll('[data-preset]')) button.disabled = names.length === 0;
}

let isAsking = false;
listen(async () => {
  const camera = selectedCamera();
  panel.hidden = !hasHead(camera);
  if (panel.hidden || isAsking) return;
  isAsking = true;
  try {
    show(camera.name, await call('ptz.status', { camera: camera.name }));
  } catch {
    // A camera that is gone, or has no head any more, is told by the next look.
  }
  isAsking = false;
});

for (const button of panel.querySelectorAll('[data-method]')) {
  button.addEventListener('click', () => {
    const { name } = selectedCamera();
    const params = 'preset' in button.dataset ? { preset: presets.value } : {};
    tellHead(name, button.dataset.method, params);
  });
}
panel.querySelector('form').addEventListener('submit', (event) => {
  event.preventDefault();
  const { name } = event.target.elements;
  tellHead(selectedCamera().name, 'ptz.preset_set', { preset: name.value.trim() });
  name.value = '';
});
